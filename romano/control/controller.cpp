#include "romano/control/controller.h"

#include <algorithm>

#include "romano/control/send.h"

namespace romano::control {
namespace {

using mqttsn::Qos;
using Microseconds = std::chrono::duration<std::int64_t, std::micro>;

}  // namespace

bool ControlledLoop::is_next(const Sample& sample) const {
    constexpr std::uint32_t half = 0x8000'0000U;
    return !has_sample_ || sample.sequence - sequence_ - 1U < half;
}

void ControlledLoop::be_patient(Instant now) {
    given_up_at_ = now + patience + 3 * period_;
}

/// RFC 3550 section 6.4.1: what the way of a sample took longer or shorter than that of the one
/// before, without a common clock.
void ControlledLoop::measure(Instant now, const Sample& sample) {
    if (has_sample_) {
        counters_.missing += sample.sequence - sequence_ - 1U;
        const std::int64_t apart =
            std::chrono::duration_cast<Microseconds>(now - arrived_at_).count();
        const std::int64_t sent_apart = sample.tick - tick_;
        const std::int64_t change = apart - sent_apart;
        jitter_16_ += static_cast<std::uint64_t>(change < 0 ? -change : change) - jitter_16_ / 16U;
        counters_.jitter = static_cast<std::uint32_t>(jitter_16_ / 16U);
    }
    has_sample_ = true;
    ++counters_.samples;
    sequence_ = sample.sequence;
    tick_ = sample.tick;
    arrived_at_ = now;
    be_patient(now);
}

ControlledLoop* ControllerCore::loop_of(Session session) {
    const auto found = std::find_if(loops_.begin(), loops_.end(), [&](const ControlledLoop& loop) {
        return loop.session_ == session;
    });
    return found == loops_.end() ? nullptr : &*found;
}

void ControllerCore::on_message(Instant now, Bytes octets, ControllerPort& port) {
    const auto message = decode(octets);
    if (!message) {
        ++counters_.malformed;
    } else if (const auto* sample = std::get_if<Sample>(&*message)) {
        on_sample(now, *sample, port);
    } else if (const auto* invite = std::get_if<Invite>(&*message)) {
        on_invite(now, *invite, port);
    } else if (const auto* bye = std::get_if<Bye>(&*message)) {
        on_bye(*bye, port);
    }
}

void ControllerCore::on_invite(Instant now, const Invite& invite, ControllerPort& port) {
    const Reason reason = take(now, invite, port);
    if (reason != Reason::none) ++counters_.refused;
    send(invite.plant, Answer{invite.session, reason}, Qos::at_least_once, port);
}

Reason ControllerCore::take(Instant now, const Invite& invite, ControllerPort& port) {
    if (invite.session == Session::none) return Reason::no_such_loop;
    if (ControlledLoop* const known = loop_of(invite.session)) {
        if (known->plant_ != invite.plant) return Reason::session_in_use;
        known->has_sample_ = false;  // whatever was taken for its latest one
        known->be_patient(now);
        return Reason::none;
    }
    for (ControlledLoop& loop : loops_) {
        const bool is_same = loop.plant_ == invite.plant && loop.channel_ == invite.channel;
        if (!loop.is_free() && is_same) leave(loop, Reason::no_such_loop, port);
    }
    ControlledLoop* const loop = loop_of(Session::none);
    if (loop == nullptr) return Reason::controller_full;
    if (!port.begin(place_of(*loop), invite)) return Reason::no_such_law;
    *loop = {};
    loop->session_ = invite.session;
    loop->plant_ = invite.plant;
    loop->channel_ = invite.channel;
    loop->period_ = to_duration(std::chrono::milliseconds{invite.period_ms});
    loop->be_patient(now);
    return Reason::none;
}

void ControllerCore::on_sample(Instant now, const Sample& sample, ControllerPort& port) {
    ControlledLoop* const loop =
        sample.session == Session::none ? nullptr : loop_of(sample.session);
    if (loop == nullptr) {
        ++counters_.foreign;
        return;
    }
    if (!loop->is_next(sample)) {
        ++loop->counters_.repeated;
        return;
    }
    loop->measure(now, sample);
    std::array<std::uint8_t, most_value> room;
    const auto size = port.control(place_of(*loop), sample, room);
    if (!size) return;
    send(loop->plant_,
         Command{.session = sample.session,
                 .sequence = sample.sequence,
                 .tick = sample.tick,
                 .value = Bytes{room}.first(std::min(*size, room.size()))},
         Qos::at_most_once, port);
}

void ControllerCore::on_bye(const Bye& bye, ControllerPort& port) {
    ControlledLoop* const loop = bye.session == Session::none ? nullptr : loop_of(bye.session);
    if (loop != nullptr) leave(*loop, bye.reason, port);
}

void ControllerCore::leave(ControlledLoop& loop, Reason reason, ControllerPort& port) {
    loop.session_ = Session::none;
    port.on_end(place_of(loop), reason);
}

void ControllerCore::end(Place place, ControllerPort& port) {
    const auto index = static_cast<std::size_t>(place);
    if (index >= loops_.size() || loops_[index].is_free()) return;
    ControlledLoop& loop = loops_[index];
    send(loop.plant_, End{loop.session_, id_}, Qos::at_least_once, port);
    leave(loop, Reason::not_allowed, port);
}

void ControllerCore::on_tick(Instant now, ControllerPort& port) {
    for (ControlledLoop& loop : loops_) {
        if (!loop.is_free() && loop.given_up_at_ <= now) leave(loop, Reason::no_answer, port);
    }
}

Instant ControllerCore::next_wakeup() const {
    Instant next = never;
    for (const ControlledLoop& loop : loops_) {
        if (!loop.is_free()) next = std::min(next, loop.given_up_at_);
    }
    return next;
}

}  // namespace romano::control
