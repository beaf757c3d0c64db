#include "experiments/loops/loop_robot.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>
#include <utility>
#include <variant>

#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

using mqttsn::Qos;

constexpr std::uint32_t first_node = 5'000;
constexpr client::KeepAlive keep_alive{30};  // as node::NodeOptions

Endpoint address_of(std::uint32_t number) {
    Endpoint endpoint{.port = 5'000, .family = Endpoint::Family::ipv4};
    endpoint.address = {10, 3, static_cast<std::uint8_t>(number / 250),
                        static_cast<std::uint8_t>(number % 250 + 1)};
    return endpoint;
}

}  // namespace

RomanoId id_of_robot(std::uint32_t number) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", number);
    return *RomanoId::parse(digits);
}

LoopRobot::LoopRobot(sim::World& world, std::uint32_t number, const Endpoint& broker,
                     Device& device)
    : world_(world),
      id_(id_of_robot(number)),
      address_(address_of(number)),
      node_(sim::Node{first_node + number}),
      broker_(broker),
      device_(device),
      client_({}, sim::seed_of(world.seed(), "loop client", number)),
      plant_({.id = id_, .seed = sim::seed_of(world.seed(), "loop plant", number)}),
      controller_(id_) {}

LoopRobot::~LoopRobot() {
    if (binding_) world_.clients().unbind(*binding_);
}

void LoopRobot::start() {
    binding_ = world_.clients().bind(
        address_, node_,
        [this](const Endpoint&, const Endpoint&, Bytes datagram) { on_datagram(datagram); },
        [this](const Endpoint& from) { return from == broker_; });
    connect();
}

void LoopRobot::connect() {
    connect_at_ = never;
    is_subscribed_ = false;
    client_.connect(world_.now(), {.client_id = id_.text(), .keep_alive = keep_alive}, out_);
    drain();
}

void LoopRobot::lose_broker() {
    is_subscribed_ = false;
    connect_at_ = world_.now() + connect_again;
}

void LoopRobot::roam_to(const Endpoint& broker) {
    broker_ = broker;
    client_.on_broker_changed(world_.now());
    rearm();
}

void LoopRobot::open(const RomanoId& plant, const RomanoId& controller,
                     const LoopSettings& settings) {
    wishes_.push_back({plant, controller, settings});
    ask_at_ = world_.now();
    rearm();
}

void LoopRobot::ask() {
    ask_at_ = wishes_.empty() ? never : world_.now() + ask_again;
    if (!is_ready()) return;
    for (const Wish& wish : std::vector<Wish>{wishes_}) {
        say(wish.plant, control::Ask{control::Channel{0}, id_});
    }
}

void LoopRobot::on_report(const control::Report& report) {
    const auto wish = std::ranges::find(wishes_, report.plant, &Wish::plant);
    if (wish == wishes_.end()) return;
    if (report.state != control::State::free) {
        wishes_.erase(wish);
    } else if (report.reason == control::Reason::none) {
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
    (void)client_.publish(world_.now(), client::topic_name(to.text()), message, {.qos = qos}, out_);
    drain();
}

void LoopRobot::on_datagram(Bytes datagram) {
    client_.on_datagram(world_.now(), datagram, out_);
    drain();
}

void LoopRobot::drain() {
    for (const Bytes datagram : out_.datagrams()) {
        world_.clients().send(node_, address_, broker_, datagram);
    }
    // Events are handled after the fact: what they lead to needs out_ again.
    const std::vector<client::Event> events(out_.events().begin(), out_.events().end());
    out_.clear();
    for (const client::Event& event : events) on_event(event);
    rearm();
}

void LoopRobot::on_event(const client::Event& event) {
    if (std::holds_alternative<client::Connected>(event)) {
        const auto asked = client_.subscribe(world_.now(), client::topic_name(id_.text()),
                                             Qos::exactly_once, out_);
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
        plant_.on_message(world_.now(), message, *this);
        controller_.on_message(world_.now(), message, *this);
        const auto decoded = control::decode(message);
        const auto* report = decoded ? std::get_if<control::Report>(&*decoded) : nullptr;
        if (report != nullptr) on_report(*report);
    }
}

void LoopRobot::on_timer() {
    const Instant now = world_.now();
    plant_.on_tick(now, *this);
    controller_.on_tick(now, *this);
    if (ask_at_ <= now) ask();
    if (connect_at_ <= now) connect();
    if (client_.next_wakeup() <= now) client_.on_tick(now, out_);
    drain();
}

void LoopRobot::rearm() {
    const Instant next = std::min({client_.next_wakeup(), plant_.next_wakeup(),
                                   controller_.next_wakeup(), connect_at_, ask_at_});
    if (next == never) return;
    const Instant wanted = std::max(next, world_.now());
    if (wanted >= timer_) return;
    timer_ = wanted;
    world_.events().at(wanted, [this, wanted] {
        if (timer_ != wanted) return;
        timer_ = never;
        on_timer();
    });
}

std::size_t LoopRobot::sense(control::Channel, MutableBytes room) {
    return device_.sense(world_.now(), room);
}

void LoopRobot::end_of_command() {
    if (sampled_at_) greatest_age_ = std::max(greatest_age_, world_.now() - *sampled_at_);
    sampled_at_.reset();
}

void LoopRobot::carry_out(control::Channel, Bytes value) {
    end_of_command();
    longest_wait_ = std::max(longest_wait_, world_.now() - carried_out_at_);
    carried_out_at_ = world_.now();
    sampled_at_ = world_.now() - std::chrono::microseconds{loop().ages().last};
    device_.carry_out(world_.now(), value);
}

void LoopRobot::fall_back(control::Channel, control::Fallback fallback) {
    end_of_command();
    device_.fall_back(world_.now(), fallback);
}

bool LoopRobot::begin(control::Place, const control::Invite&) {
    return true;
}

std::optional<std::size_t> LoopRobot::control(control::Place place, const control::Sample& sample,
                                              MutableBytes room) {
    const auto& loop = controller_.loops()[static_cast<std::size_t>(place)];
    return device_.control(world_.now(), loop.plant(), sample, room);
}

}  // namespace romano::experiments
