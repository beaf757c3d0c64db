#include "experiments/web/fleet_watch.h"

#include <array>
#include <chrono>
#include <functional>
#include <utility>
#include <variant>

#include "broker/net/clock.h"
#include "experiments/fleet/picture_feed.h"
#include "experiments/operator/own_id.h"
#include "experiments/operator/robot_message.h"
#include "experiments/watch/broker_status.h"
#include "romano/server/server.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr auto tick_every = 50ms;
constexpr auto echo_every = 200ms;
constexpr auto echo_is_lost_after = 2s;
// Then the broker is asked whether it is there at all: who only hears does not know.
constexpr auto echo_is_missed_after = 1s;
constexpr auto connect_again_after = 1s;
// Robots are asked a few at a time: thousands of questions at once would be a burst.
constexpr int most_asked_at_once = 20;
// A client has one exchange open at a time. What is said to thousands waits here, and the page is
// served meanwhile; the client has what it needs to go on at once.
constexpr std::size_t most_open = 8;
constexpr std::size_t most_waiting = 50'000;
constexpr std::uint64_t no_command = 0;

/// Where robots say where they are when they are asked; 15 octets at most, which all can name.
constexpr std::string_view place_prefix = "at/";

std::array<std::uint8_t, 8> octets_of(std::uint64_t number) {
    std::array<std::uint8_t, 8> out{};
    for (std::uint8_t& octet : out) {
        octet = static_cast<std::uint8_t>(number);
        number >>= 8U;
    }
    return out;
}

std::uint64_t number_in(Bytes octets) {
    std::uint64_t number = 0;
    for (std::size_t at = octets.size(); at > 0; --at) number = number << 8U | octets[at - 1];
    return number;
}

}  // namespace

FleetWatch::FleetWatch(boost::asio::io_context& io, FleetWatchOptions options,
                       FleetPicture& picture)
    : io_(io),
      options_(std::move(options)),
      picture_(picture),
      loops_(id_of_this_machine()),
      echo_topic_(std::string{echo_prefix} + options_.client_id),
      timer_(io) {
    connect();
    tick();
}

void FleetWatch::connect() {
    connect_due_.reset();
    failed_ = false;
    // A new one: what the old one had not sent yet was meant for that moment.
    old_client_ = std::move(client_);
    client_ = std::make_unique<WatcherClient>(
        io_, options_.broker, options_.timing, std::hash<std::string>{}(options_.client_id),
        [this, life = ++life_](const client::Event& event) {
            if (life == life_) on_event(event);
        },
        options_.packets);
    client_->connect({.client_id = options_.client_id,
                      .clean_session = true,
                      .keep_alive = options_.keep_alive});
}

void FleetWatch::leave() {
    leaving_ = true;
    timer_.cancel();
    client_->disconnect();
}

void FleetWatch::subscribe_to_all() {
    const auto subscribe = [this](std::string_view filter, Qos qos) {
        (void)client_->subscribe(client::topic_name(filter), qos);
    };
    subscribe(brokers_filter, Qos::at_least_once);
    subscribe_to_entries();
    for (const std::string& filter : options_.filters) subscribe(filter, Qos::at_most_once);
    if (options_.filters == std::vector<std::string>{"#"}) return;
    subscribe(server::common_topic, Qos::at_most_once);
    subscribe(std::string{place_prefix} + '+', Qos::at_most_once);
    subscribe(echo_topic_, Qos::at_most_once);
    subscribe(loops_.self().text(), Qos::at_most_once);
}

void FleetWatch::subscribe_to_entries() {
    const auto begun =
        client_->subscribe(client::topic_name(server::entries_filter), Qos::at_least_once);
    if (begun) entries_ = *begun;
}

void FleetWatch::on_event(const client::Event& event) {
    if (leaving_) return;
    if (std::holds_alternative<client::Connected>(event)) {
        has_begun_ = true;
        denial_.reset();
        picture_.on_link(net::now(), true);
        subscribe_to_all();
    } else if (const auto* received = std::get_if<client::Received>(&event)) {
        on_received(*received);
    } else if (const auto* subscribed = std::get_if<client::Subscribed>(&event)) {
        if (subscribed->operation == entries_) missed_.on_subscribed(net::now());
    } else if (const auto* published = std::get_if<client::Published>(&event)) {
        on_ended(published->operation, true);
    } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
        denial_ = refused->return_code;
        lose();
    } else if (const auto* denied = std::get_if<client::Failed>(&event)) {
        if (!open_.contains(denied->operation) && !has_begun_) denial_ = denied->return_code;
        on_ended(denied->operation, false);
    } else if (std::holds_alternative<client::Lost>(event) ||
               std::holds_alternative<client::Disconnected>(event)) {
        lose();
    }
}

void FleetWatch::lose() {
    failed_ = true;
    missed_.on_lost();
    picture_.on_link(net::now(), false);
    loops_to_end_.clear();
    for (const auto& [operation, command] : std::exchange(open_, {})) end_command(command, false);
    for (const Outgoing& one : std::exchange(outgoing_, {})) end_command(one.command, false);
    for (; !echoes_.empty(); echoes_.pop_front()) picture_.on_echo_lost();
    connect_due_ = net::now() + connect_again_after;
}

void FleetWatch::on_received(const client::Received& received) {
    const std::string_view topic = received.topic.name;
    if (topic == echo_topic_) return on_echo(received.data);
    if (topic == loops_.self().text()) {
        for (const LoopStop::ToRobot& message : loops_.on_answer(net::now(), received.data)) {
            tell(message);
        }
    }
    if (const auto robot = server::robot_of_entry(topic)) {
        missed_.on_entry(net::now(), *robot, received.retain);
    }
    tell_picture(picture_, net::now(), topic, received.data);
}

void FleetWatch::look_for_missed_entries(Instant now) {
    if (missed_.asks(now)) subscribe_to_entries();
    if (!missed_.is_answered(now)) return;
    std::vector<message::RomanoId> left;
    for (const auto& [id, robot] : picture_.robots()) {
        if (!missed_.was_told(id)) left.push_back(id);
    }
    for (const message::RomanoId& id : left) picture_.on_entry_deleted(now, id);
}

void FleetWatch::on_echo(Bytes data) {
    const std::uint64_t number = number_in(data);
    while (!echoes_.empty() && echoes_.front().number < number) {
        echoes_.pop_front();
        picture_.on_echo_lost();
    }
    if (echoes_.empty() || echoes_.front().number != number) return;
    picture_.on_echo(net::now() - echoes_.front().sent);
    echoes_.pop_front();
}

void FleetWatch::on_ended(client::OperationId operation, bool broker_has_it) {
    const auto exchange = open_.find(operation);
    if (exchange == open_.end()) return;
    end_command(exchange->second, broker_has_it);
    open_.erase(exchange);
    send_next();
}

void FleetWatch::end_command(std::uint64_t command, bool broker_has_it) {
    if (command != no_command) picture_.on_command_ended(command, broker_has_it);
}

void FleetWatch::publish(std::string_view topic, Bytes data, Qos qos) {
    (void)client_->publish(client::topic_name(topic), data, {.qos = qos});
}

void FleetWatch::tell(const LoopStop::ToRobot& message) {
    const auto begun = client_->publish(client::topic_name(message.robot.text()), message.octets,
                                        {.qos = Qos::at_least_once});
    if (begun) open_[*begun] = no_command;
}

std::uint64_t FleetWatch::carry_out(const Orders& orders) {
    const std::uint64_t command = picture_.on_command(net::now(), orders.words, orders.robots);
    for (const Order& order : orders.orders) {
        if (outgoing_.size() < most_waiting) {
            outgoing_.push_back({order, command});
        } else {
            end_command(command, false);
        }
    }
    for (const message::RomanoId& robot : orders.robots) {
        const auto found = picture_.robots().find(robot);
        const bool has_loops =
            found != picture_.robots().end() && found->second.entry.form == Form::binary;
        if (orders.ends_loops && has_loops && loops_to_end_.size() < most_waiting) {
            loops_to_end_.push_back(robot);
        }
    }
    send_next();
    return command;
}

void FleetWatch::send_next() {
    while (open_.size() < most_open) {
        if (!outgoing_.empty()) {
            const auto [order, command] = std::move(outgoing_.front());
            outgoing_.pop_front();
            const auto begun =
                client_->publish(client::topic_name(order.topic), order.octets, {.qos = order.qos});
            if (begun) {
                open_[*begun] = command;
            } else {
                end_command(command, false);
            }
        } else if (!loops_to_end_.empty()) {
            const message::RomanoId robot = loops_to_end_.front();
            loops_to_end_.pop_front();
            tell(loops_.begin(net::now(), robot));
        } else {
            return;
        }
    }
}

void FleetWatch::tick() {
    const Instant now = net::now();
    if (connect_due_ && now >= *connect_due_) connect();
    if (picture_.is_linked()) {
        send_echo(now);
        look_for_missed_entries(now);
        if (options_.ask_every > Duration{0} && picture_.is_linked()) ask_for_places(now);
    }
    picture_.on_tick(now);
    timer_.expires_after(tick_every);
    timer_.async_wait([this](const boost::system::error_code& stopped) {
        if (!stopped) tick();
    });
}

void FleetWatch::send_echo(Instant now) {
    while (!echoes_.empty() && now - echoes_.front().sent > echo_is_lost_after) {
        echoes_.pop_front();
        picture_.on_echo_lost();
    }
    if (!echoes_.empty() && now - echoes_.front().sent > echo_is_missed_after) client_->probe();
    if (now < echo_due_ || !picture_.is_linked()) return;
    echo_due_ = now + echo_every;
    echoes_.push_back({.number = ++last_echo_, .sent = now});
    publish(echo_topic_, octets_of(last_echo_), Qos::at_most_once);
}

void FleetWatch::ask_for_places(Instant now) {
    int asked = 0;
    std::erase_if(asked_, [&](const auto& one) { return !picture_.robots().contains(one.first); });
    for (const auto& [id, robot] : picture_.robots()) {
        if (asked >= most_asked_at_once) break;
        if (robot.entry.form != Form::binary) continue;
        if (robot.entry.state != server::NodeState::connected) continue;
        if (robot.place && now - robot.placed_at < options_.ask_every) continue;
        const auto [last, is_first] = asked_.try_emplace(id, now);
        if (!is_first && now - last->second < options_.ask_every) continue;
        last->second = now;
        ++asked;
        const std::string answer_topic = std::string{place_prefix} + std::string{id.text()};
        publish(id.text(), request_message(Form::binary, answer_topic, "location"),
                Qos::at_most_once);
    }
}

}  // namespace romano::experiments
