#include "experiments/loops/loop_robot.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <string_view>
#include <utility>
#include <variant>

#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

using mqttsn::Qos;

constexpr client::KeepAlive keep_alive{30};  // as node::NodeOptions
constexpr std::chrono::seconds t_retry{1};   // as romano-robot

}  // namespace

RomanoId id_of_robot(std::uint32_t number) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", number);
    return *RomanoId::parse(digits);
}

LoopRobot::LoopRobot(Surroundings& surroundings, std::uint64_t seed, std::uint32_t number,
                     const BrokerAddress& broker, Device& device)
    : surroundings_(surroundings),
      id_(id_of_robot(number)),
      device_(device),
      client_({.t_retry = t_retry}, sim::seed_of(seed, "loop client", number)),
      plant_({.id = id_, .seed = sim::seed_of(seed, "loop plant", number)}),
      controller_(id_),
      alarm_(surroundings.make_alarm([this] { on_timer(); })),
      port_(surroundings.open_port(broker, {}, [this](Bytes datagram) { on_datagram(datagram); })) {
}

void LoopRobot::start() {
    connect();
}

void LoopRobot::connect() {
    connect_at_ = never;
    is_subscribed_ = false;
    client_.connect(now(), {.client_id = id_.text(), .keep_alive = keep_alive}, out_);
    drain();
}

void LoopRobot::lose_broker() {
    is_subscribed_ = false;
    connect_at_ = now() + connect_again;
}

void LoopRobot::roam_to(const BrokerAddress& broker) {
    port_->talk_to(broker);
    client_.on_broker_changed(now());
    rearm();
}

void LoopRobot::open(const RomanoId& plant, const RomanoId& controller,
                     const LoopSettings& settings) {
    wishes_.push_back({plant, controller, settings});
    ask_at_ = now();
    rearm();
}

void LoopRobot::ask() {
    ask_at_ = wishes_.empty() ? never : now() + ask_again;
    if (!is_ready()) return;
    for (const Wish& wish : std::vector<Wish>{wishes_}) {
        say(wish.plant, control::Ask{control::Channel{0}, id_});
    }
}

void LoopRobot::on_report(const control::Report& report) {
    const auto wish = std::ranges::find(wishes_, report.plant, &Wish::plant);
    if (wish == wishes_.end()) return;
    if (report.state == control::State::waiting || report.state == control::State::controlled) {
        wishes_.erase(wish);
    } else if (report.state == control::State::free && report.reason == control::Reason::none) {
        say(report.plant, control::Open{.channel = control::Channel{0},
                                        .ticket = report.session,
                                        .asker = id_,
                                        .controller = wish->controller,
                                        .law = control::Law{0},
                                        .period_ms = wish->settings.period_ms,
                                        .deadline_ms = wish->settings.deadline_ms,
                                        .lease_s = 0,
                                        .fallback = wish->settings.fallback,
                                        .ends_then = false,
                                        .parameters = {}});
    }
}

template <typename M>
void LoopRobot::say(const RomanoId& to, const M& message) {
    std::array<std::uint8_t, control::largest_message> room;
    publish(to, Bytes{room}.first(control::encode(message, room)), Qos::at_least_once);
}

void LoopRobot::publish(const RomanoId& to, Bytes message, Qos qos) {
    (void)client_.publish(now(), client::topic_name(to.text()), message, {.qos = qos}, out_);
    drain();
}

void LoopRobot::on_datagram(Bytes datagram) {
    client_.on_datagram(now(), datagram, out_);
    drain();
}

void LoopRobot::drain() {
    for (const Bytes datagram : out_.datagrams()) port_->send(datagram);
    // Events are handled after the fact: what they lead to needs out_ again.
    const std::vector<client::Event> events(out_.events().begin(), out_.events().end());
    out_.clear();
    for (const client::Event& event : events) on_event(event);
    rearm();
}

void LoopRobot::on_event(const client::Event& event) {
    if (std::holds_alternative<client::Connected>(event)) {
        const auto asked =
            client_.subscribe(now(), client::topic_name(id_.text()), Qos::exactly_once, out_);
        if (asked) subscription_ = *asked;
        drain();
    } else if (const auto* subscribed = std::get_if<client::Subscribed>(&event)) {
        is_subscribed_ = is_subscribed_ || subscription_ == subscribed->operation;
    } else if (std::holds_alternative<client::Lost>(event) ||
               std::holds_alternative<client::Refused>(event) ||
               std::holds_alternative<client::Disconnected>(event)) {
        lose_broker();
    } else if (const auto* received = std::get_if<client::Received>(&event)) {
        const Bytes message = received->data;
        if (!control::is_of_a_loop(message)) return;
        plant_.on_message(now(), message, *this);
        controller_.on_message(now(), message, *this);
        const auto decoded = control::decode(message);
        const auto* report = decoded ? std::get_if<control::Report>(&*decoded) : nullptr;
        if (report != nullptr) on_report(*report);
    }
}

void LoopRobot::on_timer() {
    const Instant at = now();
    plant_.on_tick(at, *this);
    controller_.on_tick(at, *this);
    if (ask_at_ <= at) ask();
    if (connect_at_ <= at) connect();
    if (client_.next_wakeup() <= at) client_.on_tick(at, out_);
    drain();
}

void LoopRobot::rearm() {
    alarm_->set(std::min({client_.next_wakeup(), plant_.next_wakeup(), controller_.next_wakeup(),
                          connect_at_, ask_at_}));
}

std::size_t LoopRobot::sense(control::Channel, MutableBytes room) {
    return device_.sense(now(), room);
}

void LoopRobot::end_of_command() {
    if (sampled_at_) greatest_age_ = std::max(greatest_age_, now() - *sampled_at_);
    sampled_at_.reset();
}

void LoopRobot::carry_out(control::Channel, Bytes value) {
    end_of_command();
    longest_wait_ = std::max(longest_wait_, now() - carried_out_at_);
    carried_out_at_ = now();
    sampled_at_ = now() - std::chrono::microseconds{loop().ages().last};
    device_.carry_out(now(), value);
}

void LoopRobot::fall_back(control::Channel, control::Fallback fallback) {
    end_of_command();
    device_.fall_back(now(), fallback);
}

bool LoopRobot::begin(control::Place, const control::Invite&) {
    return true;
}

std::optional<std::size_t> LoopRobot::control(control::Place place, const control::Sample& sample,
                                              MutableBytes room) {
    const auto& loop = controller_.loops()[static_cast<std::size_t>(place)];
    return device_.control(now(), loop.plant(), sample, room);
}

}  // namespace romano::experiments
