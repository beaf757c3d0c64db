#include "overlay/ros2/dds/ros2_thread.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

#include "broker/net/clock.h"
#include "broker/net/turn_clock.h"

namespace romano::ros2 {
namespace {

using namespace std::chrono_literals;

// A thousand robots that appear together are not told of a thousand times.
constexpr Duration between_tellings = 100ms;
constexpr std::size_t most_warnings = 100;

// A robot's endpoints take a millisecond; what is said meanwhile waits so long at most.
constexpr std::size_t met_at_once = 5;

}  // namespace

Ros2Thread::Ros2Thread(boost::asio::io_context& io, const RosSettings& settings,
                       std::vector<Rule> rules, uplink::LinkEvents events)
    : io_(io), events_(std::move(events)), core_(std::move(rules)), side_(settings, [this] {
          {
              const std::lock_guard lock(mutex_);
              ready_ = true;
          }
          changed_.notify_one();
      }) {}

// --- the broker's thread

void Ros2Thread::start() {
    runs_ = std::thread([this] { run(); });
}

void Ros2Thread::open() {
    {
        const std::lock_guard lock(mutex_);
        ++life_;
    }
    command(Open{});
}

void Ros2Thread::close() {
    {
        const std::lock_guard lock(mutex_);
        ++life_;
    }
    command(Close{});
}

void Ros2Thread::publish(const uplink::PublishUp& up) {
    // What waits in the session is bounded by the uplink core's window, and must be answered.
    const bool wants_answer = up.message->position.seq != 0;
    {
        const std::lock_guard lock(mutex_);
        if (waiting_out_ >= most_waiting && up.qos == mqttsn::Qos::at_most_once) {
            ++facts_.overflow_out;
            return;
        }
        ++waiting_out_;
    }
    command(Outgoing{.message = {.topic = up.message->topic,
                                 .payload = up.message->payload,
                                 .unix_ms = up.message->published_at.unix_ms()},
                     .position = up.message->position,
                     .wants_answer = wants_answer});
}

void Ros2Thread::command(Command what) {
    {
        const std::lock_guard lock(mutex_);
        commands_.push_back(std::move(what));
    }
    changed_.notify_one();
}

void Ros2Thread::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_one();
    if (runs_.joinable()) runs_.join();
}

Ros2Facts Ros2Thread::facts() const {
    const std::lock_guard lock(mutex_);
    return facts_;
}

void Ros2Thread::on_report(Report& report) {
    {
        const std::lock_guard lock(mutex_);
        waiting_in_ -= report.messages.size();
        if (stopping_ || report.life != life_) return;
    }
    if (report.is_up) events_.on_up(true);
    for (const auto& position : report.answered) {
        events_.on_answer(position, uplink::Answer::done);
    }
    for (const auto& message : report.messages) events_.on_message(message, 0);
}

// --- its own thread

void Ros2Thread::run() {
    std::deque<Command> commands;
    while (wait(commands)) {
        now_ = net::now();
        for (const Command& command : commands) {
            carry_out(command);
            carry_out_actions();
        }
        commands.clear();
        look_at_writers();
        const bool knows_more = meet_known();
        const bool more = side_.take([this](const RosSample& sample) {
            identity_ = sample.identity;
            core_.on_ros(sample.topic, sample.message, actions_);
            carry_out_actions();
        });
        if (is_open_) core_.on_tick(now_, actions_);
        carry_out_actions();
        tell_nodes();
        send_report();
        const std::lock_guard lock(mutex_);
        ready_ = ready_ || more || knows_more;
        facts_.is_open = is_open_;
        facts_.endpoints = core_.endpoints();
        facts_.counters = core_.counters();
    }
    core_.close(actions_);
    carry_out_actions();
    side_.close();
    side_.nodes().tell();
}

bool Ros2Thread::wait(std::deque<Command>& commands) {
    const Instant wakeup =
        std::min(core_.next_wakeup(), side_.nodes().has_changed() ? tell_nodes_at_ : never);
    std::unique_lock lock(mutex_);
    const auto has_work = [this] { return stopping_ || ready_ || !commands_.empty(); };
    if (wakeup == never) {
        changed_.wait(lock, has_work);
    } else {
        changed_.wait_for(lock, std::max(wakeup - net::now(), Duration::zero()), has_work);
    }
    commands.swap(commands_);
    waiting_out_ = 0;
    ready_ = false;
    return !stopping_;
}

void Ros2Thread::carry_out(const Command& command) {
    if (const auto* outgoing = std::get_if<Outgoing>(&command)) {
        if (!is_open_) return;
        core_.on_romano(now_, outgoing->message, actions_);
        if (outgoing->wants_answer) report_.answered.push_back(outgoing->position);
        return;
    }
    is_open_ = std::holds_alternative<Open>(command);
    core_.close(actions_);
    carry_out_actions();
    side_.close();
    known_.clear();
    ++open_life_;
    report_ = {};
    if (!is_open_) {
        side_.nodes().tell();
        spdlog::info("ros2: left to another broker");
        return;
    }
    core_.open(actions_);
    // Velocities first: nobody shall drive on for a dead leader.
    for (RosWriter& writer : side_.writers()) {
        const bool drives = writer.of_a_bridge && writer.type == name_of(RosType::twist);
        known_.insert(drives ? known_.begin() : known_.end(), std::move(writer));
    }
    report_.is_up = true;
    tell_nodes_at_ = Instant::min();
    spdlog::info("ros2: bridged here");
}

bool Ros2Thread::meet_known() {
    for (std::size_t i = 0; i < met_at_once && !known_.empty(); ++i) {
        if (known_.front().of_a_bridge) core_.take_over(known_.front().topic, actions_);
        meet(known_.front());
        carry_out_actions();
        known_.pop_front();
    }
    return !known_.empty();
}

void Ros2Thread::look_at_writers() {
    const auto found = side_.new_writers();
    if (!is_open_) return;
    for (const RosWriter& writer : found) meet(writer);
    carry_out_actions();
}

/// Somebody publishes on a topic that a rule may want.
void Ros2Thread::meet(const RosWriter& writer) {
    if (writer.of_a_bridge) return;
    const Rule* rule = core_.on_ros_writer(writer.topic, actions_);
    if (rule == nullptr || warned_.size() >= most_warnings) return;
    std::string why;
    if (writer.type != name_of(rule->type)) {
        why = "is " + writer.type + " there and " + std::string(name_of(rule->type)) + " here";
    } else if (!writer.reliable && rule->qos != mqttsn::Qos::at_most_once) {
        why = "is published best-effort there; give the rule qos=0";
    } else if (!writer.retained && rule->retained) {
        why = "is not transient-local there; give the rule retained=no";
    }
    if (why.empty() || !warned_.insert(writer.topic).second) return;
    spdlog::warn("ros2: nothing comes from {}, line {} of the rules: it {}", writer.topic,
                 rule->line, why);
}

void Ros2Thread::carry_out_actions() {
    std::size_t part = 0;  // of what one sample becomes
    for (BridgeAction& action : actions_) {
        if (const auto* endpoint = std::get_if<MakeEndpoint>(&action)) {
            try {
                side_.make(*endpoint);
            } catch (const dds::DdsError& error) {
                spdlog::warn("ros2: {}", error.what());
            }
        } else if (const auto* message = std::get_if<ToRos>(&action)) {
            if (side_.write(message->topic, message->message)) continue;
            const std::lock_guard lock(mutex_);
            ++facts_.not_written;
        } else {
            auto& inbound = std::get<ToRomano>(action);
            report_.messages.push_back({.topic = std::move(inbound.topic),
                                        .payload = std::move(inbound.payload),
                                        .qos = inbound.qos,
                                        .retain = inbound.retain,
                                        .identity = identity_ + '/' + std::to_string(part++)});
        }
    }
    actions_.clear();
}

void Ros2Thread::tell_nodes() {
    if (!side_.nodes().has_changed() || now_ < tell_nodes_at_) return;
    side_.nodes().tell();
    tell_nodes_at_ = now_ + between_tellings;
}

void Ros2Thread::send_report() {
    if (!report_.is_up && report_.answered.empty() && report_.messages.empty()) return;
    const std::lock_guard lock(mutex_);  // after stop() the io_context may be gone at any moment
    if (stopping_) return;
    if (waiting_in_ + report_.messages.size() > most_waiting) {
        const std::size_t room = most_waiting - waiting_in_;
        facts_.overflow_in += report_.messages.size() - room;
        report_.messages.resize(room);
    }
    waiting_in_ += report_.messages.size();
    report_.life = open_life_;
    net::post_turn(io_, [weak = weak_from_this(), report = std::move(report_)]() mutable {
        if (const auto self = weak.lock()) self->on_report(report);
    });
    report_ = {};
}

}  // namespace romano::ros2
