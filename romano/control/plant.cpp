#include "romano/control/plant.h"

#include <algorithm>

#include "romano/control/send.h"

namespace romano::control {
namespace {

using mqttsn::Qos;
using Microseconds = std::chrono::duration<std::int64_t, std::micro>;

constexpr Duration report_again{to_duration(std::chrono::seconds{1})};

std::uint32_t to_tick(Instant at) {
    const auto microseconds = std::chrono::duration_cast<Microseconds>(at.time_since_epoch());
    return static_cast<std::uint32_t>(microseconds.count());
}

/// Far under the 71 minutes after which ticks wrap: a deadline is no longer than a minute.
std::uint32_t microseconds_between(Instant from, Instant to) {
    return to_tick(to) - to_tick(from);
}

}  // namespace

void PlantLoop::report(const RomanoId& to, Reason reason, const Call& call) const {
    send(to,
         Report{.channel = call.channel,
                .session = session_,
                .plant = call.self,
                .controller = controller_,
                .state = state_,
                .reason = reason,
                .counters = counters_,
                .ages = meter_.ages()},
         Qos::at_least_once, call.port);
}

Reason PlantLoop::objection_to(const Open& open, const Call& call) const {
    if (state_ != State::free) return Reason::busy;
    if (open.ticket == Session::none || open.ticket != session_) return Reason::wrong_ticket;
    const Duration period = to_duration(std::chrono::milliseconds{open.period_ms});
    const Duration deadline = to_duration(std::chrono::milliseconds{open.deadline_ms});
    const bool is_possible =
        period > Duration::zero() && deadline > period && deadline <= period * window;
    if (!is_possible) return Reason::impossible_settings;
    return call.port.may_open(open) ? Reason::none : Reason::not_allowed;
}

void PlantLoop::on_open(const Open& open, const Call& call) {
    if (state_ != State::free && open.ticket == session_) {  // doubled
        return report(open.asker, Reason::none, call);
    }
    const Reason objection = objection_to(open, call);
    if (objection != Reason::none) return report(open.asker, objection, call);
    controller_ = open.controller;
    asker_ = open.asker;
    law_ = open.law;
    period_ms_ = open.period_ms;
    deadline_ms_ = open.deadline_ms;
    lease_s_ = open.lease_s;
    fallback_ = open.fallback;
    ends_then_ = open.ends_then;
    parameters_size_ = open.parameters.size();
    std::copy(open.parameters.begin(), open.parameters.end(), parameters_.begin());
    counters_ = {};
    meter_ = {};
    usable_ = 0;
    invitations_ = 0;
    begin_lease(call.now);
    enter(State::inviting, Reason::none, call);
    invite(call);
}

void PlantLoop::begin_lease(Instant now) {
    lease_ends_at_ = lease_s_ == 0 ? never : now + to_duration(std::chrono::seconds{lease_s_});
}

void PlantLoop::on_renew(const RomanoId& asker, const Call& call) {
    asker_ = asker;
    begin_lease(call.now);
    reported_at_ = call.now;
    report_at_ = never;
    report(asker, Reason::none, call);
}

/// Who leaves `controlled` falls back, and who enters the loop. What is held is let go with the
/// loop.
void PlantLoop::enter(State state, Reason reason, const Call& call) {
    const bool falls_back = state_ == State::controlled || state_ == State::free;
    state_ = state;
    if (state == State::free && fallback_ == Fallback::hold) {
        call.port.fall_back(call.channel, Fallback::stop);
    } else if (falls_back && state != State::controlled) {
        call.port.fall_back(call.channel, fallback_);
    }
    if (state != State::free) report_at_ = std::max(call.now, reported_at_ + report_again);
    call.port.on_state(call.channel, state, reason);
}

void PlantLoop::end(Reason reason, const Call& call) {
    if (state_ == State::free) return;
    send(controller_, Bye{session_, reason}, Qos::at_least_once, call.port);
    enter(State::free, reason, call);
    report(asker_, reason, call);
    session_ = Session::none;
    report_at_ = never;
}

void PlantLoop::invite(const Call& call) {
    ++invitations_;
    invite_at_ = call.now + invite_again;
    send(controller_,
         Invite{.session = session_,
                .plant = call.self,
                .channel = call.channel,
                .law = law_,
                .period_ms = period_ms_,
                .deadline_ms = deadline_ms_,
                .parameters = Bytes{parameters_}.first(parameters_size_)},
         Qos::at_least_once, call.port);
}

void PlantLoop::on_answer(Reason reason, const Call& call) {
    fall_back_if_due(call);
    if (state_ == State::free) return;
    if (reason != Reason::none) return end(reason, call);
    if (state_ != State::inviting) return;
    sample_at_ = call.now;
    enter(State::waiting, Reason::none, call);
    take_sample(call);
}

std::uint16_t PlantLoop::age_of_last_command() const {
    if (!meter_.has_any()) return Sample::no_age;
    const std::uint32_t age = meter_.ages().last / 100U;
    return static_cast<std::uint16_t>(std::min<std::uint32_t>(age, Sample::no_age - 1U));
}

void PlantLoop::take_sample(const Call& call) {
    sample_at_ += period();
    if (sample_at_ <= call.now) sample_at_ = call.now + period();  // the missed ones are history
    std::array<std::uint8_t, most_value> room;
    const std::size_t size = std::min(call.port.sense(call.channel, room), room.size());
    const std::uint32_t sequence = counters_.samples++;
    sent_at_[sequence % window] = call.now;
    usable_ = std::min(usable_ + 1, window);
    send(controller_,
         Sample{.session = session_,
                .sequence = sequence,
                .tick = to_tick(call.now),
                .age = age_of_last_command(),
                .value = Bytes{room}.first(size)},
         Qos::at_most_once, call.port);
}

std::uint32_t* PlantLoop::flaw_of(const Command& command, Instant now) {
    // 0 is the latest sample. Counted backwards, so that sequences may wrap.
    const std::uint32_t behind = counters_.samples - 1 - command.sequence;
    if (!is_sampling() || behind >= counters_.samples) return &counters_.foreign;
    if (behind >= window) return &counters_.late;
    const Instant sent_at = sent_at_[command.sequence % window];
    if (to_tick(sent_at) != command.tick) return &counters_.foreign;
    if (behind >= usable_) return &counters_.repeated;
    return now - sent_at < deadline() ? nullptr : &counters_.late;
}

void PlantLoop::on_command(const Command& command, const Call& call) {
    fall_back_if_due(call);
    if (std::uint32_t* const counter = flaw_of(command, call.now)) {
        ++*counter;
        return;
    }
    usable_ = counters_.samples - 1 - command.sequence;
    const Instant sent_at = sent_at_[command.sequence % window];
    falls_back_at_ = sent_at + deadline();
    ++counters_.accepted;
    meter_.add(microseconds_between(sent_at, call.now));
    if (state_ != State::controlled) enter(State::controlled, Reason::none, call);
    call.port.carry_out(call.channel, command.value);
}

void PlantLoop::fall_back_if_due(const Call& call) {
    if (state_ != State::controlled || call.now < falls_back_at_) return;
    ++counters_.falls;
    if (ends_then_) return end(Reason::fell_back, call);
    enter(State::waiting, Reason::none, call);
}

void PlantLoop::on_tick(const Call& call) {
    fall_back_if_due(call);
    if (state_ == State::free) return;
    if (lease_ends_at_ <= call.now) return end(Reason::lease_over, call);
    if (state_ != State::controlled && invite_at_ <= call.now) {
        if (state_ == State::inviting && invitations_ == most_invitations) {
            return end(Reason::no_answer, call);
        }
        invite(call);
    }
    if (is_sampling() && sample_at_ <= call.now) take_sample(call);
    if (report_at_ <= call.now) {
        report_at_ = never;
        reported_at_ = call.now;
        report(asker_, Reason::none, call);
    }
}

Instant PlantLoop::next_wakeup() const {
    if (state_ == State::free) return never;
    Instant next = std::min(lease_ends_at_, report_at_);
    next = std::min(next, state_ == State::controlled ? falls_back_at_ : invite_at_);
    return is_sampling() ? std::min(next, sample_at_) : next;
}

PlantCore::PlantCore(std::span<PlantLoop> loops, const PlantOptions& options)
    : loops_(loops), options_(options), random_(options.seed) {}

PlantLoop* PlantCore::loop_of(Channel channel) {
    const auto index = static_cast<std::size_t>(channel);
    return index < loops_.size() ? &loops_[index] : nullptr;
}

PlantLoop* PlantCore::loop_of(Session session) {
    const auto found = std::find_if(loops_.begin(), loops_.end(), [&](const PlantLoop& loop) {
        return loop.state_ != State::free && loop.session_ == session;
    });
    return found == loops_.end() ? nullptr : &*found;
}

PlantLoop::Call PlantCore::call_of(const PlantLoop& loop, Instant now, PlantPort& port) const {
    return {now, port, options_.id, Channel{static_cast<std::uint8_t>(&loop - loops_.data())}};
}

void PlantCore::deny(const RomanoId& asker, Channel channel, Session session, Reason reason,
                     PlantPort& port) const {
    send(asker,
         Report{.channel = channel,
                .session = session,
                .plant = options_.id,
                .controller = {},
                .state = State::free,
                .reason = reason,
                .counters = {},
                .ages = {}},
         Qos::at_least_once, port);
}

void PlantCore::on_ask(const Ask& ask, Instant now, PlantPort& port) {
    PlantLoop* const loop = loop_of(ask.channel);
    if (loop == nullptr) {
        return deny(ask.asker, ask.channel, Session::none, Reason::no_such_channel, port);
    }
    while (loop->session_ == Session::none) {
        // The moment makes tickets differ between two starts with one seed.
        const std::uint32_t moment = to_tick(now) * 2'654'435'761U;
        loop->session_ = Session{random_.next() + moment};
    }
    loop->report(ask.asker, Reason::none, call_of(*loop, now, port));
}

void PlantCore::on_open(const Open& open, Instant now, PlantPort& port) {
    PlantLoop* const loop = loop_of(open.channel);
    if (loop == nullptr) {
        return deny(open.asker, open.channel, open.ticket, Reason::no_such_channel, port);
    }
    loop->on_open(open, call_of(*loop, now, port));
}

void PlantCore::on_command(const Command& command, Instant now, PlantPort& port) {
    PlantLoop* const loop = loop_of(command.session);
    if (loop == nullptr) {
        ++counters_.foreign;
    } else {
        loop->on_command(command, call_of(*loop, now, port));
    }
}

void PlantCore::on_message(Instant now, Bytes octets, PlantPort& port) {
    const auto message = decode(octets);
    if (!message) {
        ++counters_.malformed;
    } else if (const auto* command = std::get_if<Command>(&*message)) {
        on_command(*command, now, port);
    } else if (const auto* ask = std::get_if<Ask>(&*message)) {
        on_ask(*ask, now, port);
    } else if (const auto* open = std::get_if<Open>(&*message)) {
        on_open(*open, now, port);
    } else if (const auto* answer = std::get_if<Answer>(&*message)) {
        PlantLoop* const loop = loop_of(answer->session);
        if (loop != nullptr) loop->on_answer(answer->reason, call_of(*loop, now, port));
    } else if (const auto* renew = std::get_if<Renew>(&*message)) {
        PlantLoop* const loop = loop_of(renew->session);
        if (loop == nullptr) {
            return deny(renew->asker, {}, renew->session, Reason::no_such_loop, port);
        }
        loop->on_renew(renew->asker, call_of(*loop, now, port));
    } else if (const auto* ends = std::get_if<End>(&*message)) {
        PlantLoop* const loop = loop_of(ends->session);
        if (loop == nullptr) {
            return deny(ends->asker, {}, ends->session, Reason::no_such_loop, port);
        }
        loop->asker_ = ends->asker;
        loop->end(Reason::ended_by_a_node, call_of(*loop, now, port));
    }
}

void PlantCore::on_tick(Instant now, PlantPort& port) {
    for (PlantLoop& loop : loops_) loop.on_tick(call_of(loop, now, port));
}

Instant PlantCore::next_wakeup() const {
    Instant next = never;
    for (const PlantLoop& loop : loops_) next = std::min(next, loop.next_wakeup());
    return next;
}

void PlantCore::end(Instant now, Channel channel, PlantPort& port) {
    PlantLoop* const loop = loop_of(channel);
    if (loop != nullptr) loop->end(Reason::not_allowed, call_of(*loop, now, port));
}

}  // namespace romano::control
