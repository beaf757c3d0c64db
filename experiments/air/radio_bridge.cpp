#include "experiments/air/radio_bridge.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/multicast.hpp>
#include <set>
#include <utility>

#include "broker/net/asio_endpoint.h"
#include "broker/net/clock.h"
#include "broker/net/socket_address.h"
#include "experiments/robots/simulated_surroundings.h"
#include "overlay/radio/layout.h"
#include "romano/mqttsn/cell.h"
#include "romano/mqttsn/decode.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::udp;

constexpr std::size_t most_octets = 1'000;  // 6LoWPAN's packets have 1280 at most
constexpr Duration place_is_kept = 60s;     // for a robot that says nothing, if others want it
constexpr sim::Node everybody{1};

/// In the world: each cell has one of its own, as routers pass on what their own broker sends.
Endpoint group_of(std::size_t cell) {
    Endpoint group = sim::World::cell_group();
    group.port = static_cast<std::uint16_t>(group.port + cell);
    return group;
}

/// True: the robot says that it listens to its cell; false: that it does not any more.
std::optional<bool> says_that_it_listens(Bytes datagram) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return {};
    if (frame->type == mqttsn::MsgType::connect || frame->type == mqttsn::MsgType::disconnect) {
        return false;
    }
    if (frame->type == mqttsn::MsgType::subscribe) {
        const auto subscribe = mqttsn::decode_subscribe(frame->body);
        if (subscribe && subscribe->topic.name == mqttsn::cell_topic) return true;
    } else if (frame->type == mqttsn::MsgType::unsubscribe) {
        const auto unsubscribe = mqttsn::decode_unsubscribe(frame->body);
        if (unsubscribe && unsubscribe->topic.name == mqttsn::cell_topic) return false;
    }
    return {};
}

/// In the world.
Endpoint place_address(std::size_t number) {
    return SimulatedSurroundings::address_of_port(static_cast<std::uint32_t>(number));
}

radio::RadioOptions radio_options(const RadioBridgeOptions& options) {
    radio::RadioOptions radio;
    radio.router_baud = options.router_baud;
    radio.robot_baud = options.robot_baud;
    radio.cells.resize(options.cells.size());
    for (std::size_t i = 0; i < radio.cells.size(); ++i) {
        radio::RadioCell& cell = radio.cells[i];
        cell.channel = lowpan::first_channel + static_cast<unsigned>(i % options.channels);
        cell.router = radio::place_on_grid(i, options.cells.size(), options.router_distance_m);
        for (std::size_t j = 0; j < options.robots; ++j) {
            cell.robots.push_back({place_address(i * options.robots + j),
                                   radio::place_around(cell.router, j, options.robots)});
        }
    }
    return radio;
}

}  // namespace

std::optional<std::string> problem_with(const RadioBridgeOptions& options) {
    if (options.group && (!net::is_multicast(*options.group) || options.group->port == 0)) {
        return "--cell-group is no multicast group and port; write the brokers', for example "
               "239.18.83.1:1884";
    }
    return radio::problem_with(radio_options(options));
}

RadioBridge::Cell::Cell(boost::asio::io_context& io, const BridgedCell& cell)
    : socket(io, net::to_asio<udp>(cell.listen)), broker(net::to_asio<udp>(cell.broker)) {
    socket.non_blocking(true);
}

RadioBridge::RadioBridge(boost::asio::io_context& io, const RadioBridgeOptions& options,
                         std::function<void()> on_lag)
    : options_(options),
      began_(net::now()),
      on_lag_(std::move(on_lag)),
      world_(options.seed),
      network_(world_, radio_options(options)),
      io_(io),
      timer_(io, [this] { catch_up(); }) {
    for (std::size_t i = 0; i < options_.cells.size(); ++i) {
        cells_.push_back(std::make_unique<Cell>(io, options_.cells[i]));
        for (std::size_t j = 0; j < options_.robots; ++j) open_place(i, i * options_.robots + j);
        (void)world_.clients().bind(sim::World::service_address(i), everybody,
                                    [this](const Endpoint&, const Endpoint& from, Bytes datagram) {
                                        hand_to_broker(from, datagram);
                                    });
        hear_robots(i);
    }
    if (options_.group) open_group(*options_.group);
    catch_up();
}

void RadioBridge::open_place(std::size_t cell, std::size_t number) {
    Place& place = places_.emplace_back(io_, cell, place_address(number));
    place_at_[place.address] = &place;
    place.to_broker.connect(cells_[cell]->broker);
    place.to_broker.non_blocking(true);
    (void)world_.clients().bind(
        place.address, everybody, [this, &place](const Endpoint&, const Endpoint&, Bytes datagram) {
            if (!place.robot) return;
            boost::system::error_code lost;
            cells_[place.cell]->socket.send_to(
                boost::asio::buffer(datagram.data(), datagram.size()), *place.robot, 0, lost);
            ++figures_.to_robots;
            on_handed_over();
        });
    hear_broker(place);
}

void RadioBridge::hand_to_broker(const Endpoint& from, Bytes datagram) {
    const auto place = place_at_.find(from);
    if (place == place_at_.end()) return;
    boost::system::error_code lost;
    place->second->to_broker.send(boost::asio::buffer(datagram.data(), datagram.size()), 0, lost);
    ++figures_.to_brokers;
    on_handed_over();
}

/// On the interfaces that lead to the brokers.
void RadioBridge::open_group(const Endpoint& group) {
    const udp::endpoint at = net::to_asio<udp>(group);
    Udp::socket& socket = group_.emplace(io_, at.protocol());
    socket.set_option(Udp::socket::reuse_address(true));  // robots here may listen there, too
    socket.bind(at);
    socket.non_blocking(true);
    std::set<boost::asio::ip::address> joined;
    for (const Place& place : places_) {
        const boost::asio::ip::address local = place.to_broker.local_endpoint().address();
        if (local.is_v6() != at.address().is_v6() || !joined.insert(local).second) continue;
        if (local.is_v4()) {
            socket.set_option(
                boost::asio::ip::multicast::join_group(at.address().to_v4(), local.to_v4()));
        } else {
            const auto v6 = at.address().to_v6();
            const auto link = v6.scope_id() != 0 ? v6.scope_id() : local.to_v6().scope_id();
            socket.set_option(boost::asio::ip::multicast::join_group(v6, link));
        }
    }
    hear_group();
}

void RadioBridge::hear_group() {
    group_->async_wait(Udp::socket::wait_read, [this](const boost::system::error_code& end) {
        if (end) return;
        for (;;) {
            Udp::endpoint from;
            boost::system::error_code none;
            const std::size_t size =
                group_->receive_from(boost::asio::buffer(octets_), from, 0, none);
            if (none) break;
            for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
                if (cells_[cell]->broker != from) continue;
                ++figures_.to_cells;
                send(sim::World::service_address(cell), group_of(cell), {octets_.data(), size});
            }
        }
        hear_group();
    });
}

void RadioBridge::let_listen(Place& place, bool listens) {
    if (!group_ || std::exchange(place.listens, listens) == listens) return;
    if (listens) {
        world_.clients().join(group_of(place.cell), place.address);
    } else {
        world_.clients().leave(group_of(place.cell), place.address);
    }
}

void RadioBridge::hear_robots(std::size_t cell) {
    Udp::socket& socket = cells_[cell]->socket;
    socket.async_wait(
        Udp::socket::wait_read, [this, cell, &socket](const boost::system::error_code& end) {
            if (end) return;
            for (;;) {
                Udp::endpoint from;
                boost::system::error_code none;
                const std::size_t size =
                    socket.receive_from(boost::asio::buffer(octets_), from, 0, none);
                if (none == boost::asio::error::would_block) break;
                if (none) continue;  // an earlier datagram found nobody
                if (Place* place = place_of(cell, from)) {
                    const auto listens = says_that_it_listens({octets_.data(), size});
                    if (listens) let_listen(*place, *listens);
                    send(place->address, sim::World::service_address(cell), {octets_.data(), size});
                } else {
                    ++figures_.without_place;
                }
            }
            hear_robots(cell);
        });
}

void RadioBridge::hear_broker(Place& place) {
    place.to_broker.async_wait(Udp::socket::wait_read, [this, &place](
                                                           const boost::system::error_code& end) {
        if (end) return;
        for (;;) {
            boost::system::error_code none;
            const std::size_t size = place.to_broker.receive(boost::asio::buffer(octets_), 0, none);
            if (none == boost::asio::error::would_block) break;
            if (none) continue;  // nobody serves there
            send(sim::World::service_address(place.cell), place.address, {octets_.data(), size});
        }
        hear_broker(place);
    });
}

/// Who has said nothing for long makes room for another one.
RadioBridge::Place* RadioBridge::place_of(std::size_t cell, const Udp::endpoint& robot) {
    auto& robots = cells_[cell]->robots;
    auto found = robots.find(robot);
    if (found == robots.end()) {
        const auto first = places_.begin() + static_cast<std::ptrdiff_t>(cell * options_.robots);
        const auto last = first + static_cast<std::ptrdiff_t>(options_.robots);
        const auto free = std::min_element(first, last, [](const Place& one, const Place& other) {
            return one.robot.has_value() != other.robot.has_value() ? !one.robot
                                                                    : one.heard < other.heard;
        });
        if (free->robot) {
            if (now() - free->heard < place_is_kept) return nullptr;
            robots.erase(*free->robot);
            let_listen(*free, false);
        }
        free->robot = robot;
        found = robots.emplace(robot, &*free).first;
    }
    found->second->heard = now();
    return found->second;
}

void RadioBridge::send(const Endpoint& from, const Endpoint& to, Bytes datagram) {
    if (datagram.size() > most_octets) {
        ++figures_.too_large;
        return;
    }
    catch_up();
    world_.clients().send(everybody, from, to, datagram);
    timer_.arm(began_ + world_.events().next().time_since_epoch());
}

void RadioBridge::on_handed_over() {
    const Duration lag = now() - world_.now();
    figures_.lag.add(lag);
    if (lag <= options_.most_lag) return;
    if (figures_.late++ == 0) on_lag_();
}

/// All that was to happen by now.
void RadioBridge::catch_up() {
    world_.events().run_until(now());
    const Instant next = world_.events().next();
    if (next != never) timer_.arm(began_ + next.time_since_epoch());
}

/// The world's time begins with this.
Instant RadioBridge::now() const {
    return Instant{net::now() - began_};
}

RadioBridgeFigures RadioBridge::figures() {
    catch_up();
    RadioBridgeFigures figures = figures_;
    figures.lost_in_queues = network_.lost();
    figures.given_up_on_air = network_.counters().given_up;
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
        const auto air = lowpan::air_time_ns(network_.sent_by_router(cell)) +
                         lowpan::air_time_ns(network_.sent_by_robots(cell));
        const auto time = std::chrono::nanoseconds{now().time_since_epoch()}.count();
        figures.air_share =
            std::max(figures.air_share, static_cast<double>(air) / static_cast<double>(time));
    }
    return figures;
}

}  // namespace romano::experiments
