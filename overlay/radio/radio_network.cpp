#include "overlay/radio/radio_network.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <limits>
#include <set>

#include "overlay/sim/seed.h"

namespace romano::radio {
namespace {

using lowpan::Device;

constexpr double nothing_dbm = -200;  // of a radio that is off

/// ns-3's O-QPSK receiver loses half of the frames of 60 octets at this ratio of signal to noise.
constexpr double half_lost_snr_db = -1.13;

constexpr std::uint32_t slowest_baud = 1'200;
constexpr std::uint32_t fastest_baud = 10'000'000;

Device router_of(const Device& device) {
    return {device.cell, 0};
}

bool is_group(const Endpoint& address) {
    return address.family == Endpoint::Family::ipv4 && address.address[0] >> 4U == 0xEU;
}

std::int64_t to_ns(Instant at) {
    return std::chrono::nanoseconds{at.time_since_epoch()}.count();
}

}  // namespace

std::optional<std::string> problem_with(const RadioOptions& options) {
    for (const RadioCell& cell : options.cells) {
        if (cell.channel < lowpan::first_channel || cell.channel > lowpan::last_channel) {
            return "channel " + std::to_string(cell.channel) +
                   " does not exist: IEEE 802.15.4 at 2.4 GHz has channels 11 to 26";
        }
        if (cell.robots.size() > lowpan::most_robots) {
            return std::to_string(cell.robots.size()) +
                   " robots are too many for one cell: at most " +
                   std::to_string(lowpan::most_robots);
        }
    }
    for (const auto baud : {options.router_baud, options.robot_baud}) {
        if (!baud || (*baud >= slowest_baud && *baud <= fastest_baud)) continue;
        return "a UART of " + std::to_string(*baud) +
               " baud cannot be: give 1200 to 10000000 baud, or none";
    }
    return std::nullopt;
}

/// A border router's host is the broker's machine.
struct RadioNetwork::Station {
    Device device;
    Endpoint robot;  // its address; a router's has none
    Place place;
    std::deque<Carried> queue;  // the first one is with the radio, unless that is ready
    bool ready = true;
    bool is_on = true;
    std::unique_ptr<SerialLine> to_radio;
    std::unique_ptr<SerialLine> to_host;
};

RadioNetwork::RadioNetwork(sim::World& world, const RadioOptions& options)
    : world_(world), options_(options) {
    std::vector<lowpan::CellPlan> plan;
    for (const RadioCell& cell : options_.cells) {
        Device device{plan.size(), 0};
        add_station(device, cell.router);
        for (const RadioRobot& robot : cell.robots) {
            ++device.number;
            add_station(device, robot.place);
            Radios& radios = robots_[robot.address];
            if (radios.all.empty()) radios.joined = device;
            stations_.at(device)->is_on = radios.all.empty();
            stations_.at(device)->robot = robot.address;
            radios.all.push_back(device);
        }
        plan.push_back({cell.channel, cell.robots.size()});
    }
    if (options_.backbone) {
        add_backbone();
        plan.push_back({.channel = options_.backbone->channel,
                        .robots = backbone_->size() - 1,
                        .all_talk = true});
    }
    const RadioModel& model = options_.model;
    channel_ = std::make_unique<lowpan::Channel>(
        plan, model.transmit_dbm, model.half_lost_dbm - half_lost_snr_db,
        sim::seed_of(world.seed(), "channel"),
        lowpan::Channel::Owner{
            [this](Device from, Device to) { return dbm(from, to); },
            [this](Device at, Device from, const std::vector<std::uint8_t>& octets) {
                on_received(at, from, octets);
            },
            [this](Device device) { on_ready(device); }});
    world_.clients().set_carrier(
        [this](sim::Node sender, const Endpoint& from, const Endpoint& to, Bytes datagram) {
            return carry({sender, from, to, {datagram.begin(), datagram.end()}});
        });
}

RadioNetwork::~RadioNetwork() {
    world_.clients().set_carrier(nullptr);
}

void RadioNetwork::add_station(const Device& device, const Place& place) {
    auto& owned = stations_[device];
    owned = std::make_unique<Station>();
    Station& station = *owned;
    station.device = device;
    station.place = place;
    const bool is_router = device.number == 0;
    const auto baud = is_router ? options_.router_baud : options_.robot_baud;
    const Framing& framing = is_router ? ethernet_over_serial : robots_hdlc;
    station.to_radio = std::make_unique<SerialLine>(
        world_.events(), baud, framing, is_router ? options_.host_queue : options_.radio_queue,
        [this, &station](const Carried& datagram) { return queue_for_radio(station, datagram); });
    station.to_host = std::make_unique<SerialLine>(
        world_.events(), baud, framing, options_.radio_queue,
        [this](const Carried& datagram) { return hand_over(datagram); });
}

void RadioNetwork::add_backbone() {
    const std::size_t pan = options_.cells.size();
    backbone_ = std::make_unique<RadioBackbone>(
        world_.events(), options_.model, options_.backbone->radios, options_.radio_queue,
        [this, pan](std::size_t from, std::optional<std::size_t> to,
                    const std::vector<std::uint8_t>& octets) {
            const std::int64_t now = to_ns(world_.now());
            if (to) {
                channel_->send(now, {pan, from}, {pan, *to}, octets);
            } else {
                channel_->broadcast(now, {pan, from}, octets);
            }
            rearm();
        });
}

bool RadioNetwork::carry(const Carried& datagram) {
    if (is_group(datagram.to)) return carry_to_listeners(datagram);
    const auto sender = robots_.find(datagram.from);
    const auto receiver = robots_.find(datagram.to);
    if (sender == robots_.end() && receiver == robots_.end()) return false;
    const Device enters =
        sender != robots_.end() ? sender->second.joined : router_of(receiver->second.joined);
    enter(*stations_.at(enters), datagram);
    return true;
}

void RadioNetwork::enter(Station& station, const Carried& datagram) {
    if (!station.is_on) return;  // lost
    if (!station.to_radio->send(datagram) && station.device.number == 0 && !first_overflow_) {
        first_overflow_ = world_.now();
    }
}

/// Once by the router of each cell where somebody listens.
bool RadioNetwork::carry_to_listeners(const Carried& datagram) {
    std::set<std::size_t> cells;
    for (const auto& [address, radios] : robots_) {
        if (world_.clients().is_listening(datagram.to, address)) cells.insert(radios.joined.cell);
    }
    for (const std::size_t cell : cells) enter(*stations_.at({cell, 0}), datagram);
    return !cells.empty();
}

/// Robots talk to their cell's router, and that to them.
bool RadioNetwork::queue_for_radio(Station& station, const Carried& datagram) {
    if (station.queue.size() >= options_.radio_queue) return false;
    station.queue.push_back(datagram);
    transmit(station);
    return true;
}

void RadioNetwork::transmit(Station& station) {
    if (!station.ready || station.queue.empty()) return;
    const Carried& datagram = station.queue.front();
    station.ready = false;
    if (is_group(datagram.to)) {
        channel_->broadcast(to_ns(world_.now()), station.device, datagram.octets);
        rearm();
        return;
    }
    // A router goes on calling a robot that has left: nobody tells it.
    const Device to = station.device.number == 0 ? *robots_.at(datagram.to).in(station.device.cell)
                                                 : router_of(station.device);
    channel_->send(to_ns(world_.now()), station.device, to, datagram.octets);
    rearm();
}

/// Not at once: the channel is in the midst of its own event.
void RadioNetwork::on_ready(const Device& device) {
    world_.events().after(Duration{0}, [this, device] {
        if (is_on_backbone(device)) return backbone_->on_ready(device.number);
        Station& station = *stations_.at(device);
        station.ready = true;
        station.queue.pop_front();
        transmit(station);
        station.to_radio->go_on();
    });
}

/// The sender does not begin its next datagram before this one is here or given up.
void RadioNetwork::on_received(const Device& at, const Device& from,
                               const std::vector<std::uint8_t>& octets) {
    if (is_on_backbone(at)) return backbone_->on_received(at.number, from.number);
    const Station& sender = *stations_.at(from);
    if (sender.queue.empty() || sender.queue.front().octets != octets) return;
    Carried datagram = sender.queue.front();
    Station& station = *stations_.at(at);
    if (is_group(datagram.to)) {  // a radio passes on what its host has joined
        if (!world_.clients().is_listening(datagram.to, station.robot)) return;
        datagram.to = station.robot;
    }
    (void)station.to_host->send(datagram);
}

/// At the end of the line: a robot, or the machine of a broker, which knows the way to any other.
bool RadioNetwork::hand_over(const Carried& datagram) {
    const auto& [sender, from, to, octets] = datagram;
    world_.clients().deliver(sender, from, to, octets);
    return true;
}

void RadioNetwork::rearm() {
    const std::int64_t next = channel_->next_wakeup_ns();
    if (next == std::numeric_limits<std::int64_t>::max()) return;
    const Instant at{std::chrono::nanoseconds{next}};
    if (at >= timer_) return;
    timer_ = at;
    world_.events().at(at, [this, at] {
        if (timer_ != at) return;
        timer_ = never;
        channel_->run_until(to_ns(at));
        rearm();
    });
}

double RadioNetwork::dbm(const Device& from, const Device& to) {
    const auto is_on = [this](const Device& device) {
        return is_on_backbone(device) || stations_.at(device)->is_on;
    };
    const bool are_on = is_on(from) && is_on(to);
    return are_on ? link_dbm(from, to) : nothing_dbm;
}

double RadioNetwork::link_dbm(const Device& from, const Device& to) {
    const auto [a, b] = std::minmax(from, to);
    auto link = links_.find({a, b});
    if (link == links_.end()) {
        const std::uint64_t number =
            (a.cell << 48U) | (a.number << 32U) | (b.cell << 16U) | b.number;
        link = links_
                   .emplace(
                       std::pair{a, b},
                       RadioLink{options_.model, sim::seed_of(world_.seed(), "radio link", number)})
                   .first;
    }
    return link->second.packet_dbm(place_of(a), place_of(b));
}

const Place& RadioNetwork::place_of(const Device& device) const {
    return is_on_backbone(device) ? backbone_->place(device.number) : stations_.at(device)->place;
}

std::optional<Device> RadioNetwork::Radios::in(std::size_t cell) const {
    const auto radio = std::ranges::find(all, cell, &Device::cell);
    return radio == all.end() ? std::nullopt : std::optional{*radio};
}

void RadioNetwork::move(const Endpoint& robot, const Place& place) {
    for (const Device& device : robots_.at(robot).all) stations_.at(device)->place = place;
}

void RadioNetwork::join(const Endpoint& robot, std::size_t cell) {
    Radios& radios = robots_.at(robot);
    stations_.at(radios.joined)->is_on = false;
    radios.joined = radios.in(cell).value();
    stations_.at(radios.joined)->is_on = true;
}

void RadioNetwork::switch_off_router(std::size_t cell) {
    stations_.at({cell, 0})->is_on = false;
}

double RadioNetwork::hears_dbm(const Endpoint& robot, std::size_t cell) {
    const Device router{cell, 0};
    const auto radio = robots_.at(robot).in(cell);
    return radio && stations_.at(router)->is_on ? link_dbm(router, *radio) : nothing_dbm;
}

lowpan::Air RadioNetwork::sent_by_robots(std::size_t cell) const {
    lowpan::Air sum;
    for (const auto& [device, station] : stations_) {
        if (device.cell != cell || device.number == 0) continue;
        const lowpan::Air& sent = channel_->sent_by(device);
        sum.frames += sent.frames;
        sum.octets += sent.octets;
    }
    return sum;
}

lowpan::Air RadioNetwork::sent_by_brokers() const {
    lowpan::Air sum;
    for (std::size_t i = 0; backbone_ && i < backbone_->size(); ++i) {
        const lowpan::Air& sent = channel_->sent_by({options_.cells.size(), i});
        sum.frames += sent.frames;
        sum.octets += sent.octets;
    }
    return sum;
}

std::uint64_t RadioNetwork::lost() const {
    std::uint64_t sum = backbone_ ? backbone_->lost() : 0;
    for (const auto& [device, station] : stations_) {
        sum += station->to_radio->lost() + station->to_host->lost();
    }
    return sum;
}

}  // namespace romano::radio
