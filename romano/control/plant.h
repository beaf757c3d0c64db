// A robot that lets others control it: a loop for each of its channels. README.md, "A loop's life
// at the plant" and "A command is carried out".
//
// The owner hands in what comes (on_message) and the time (on_tick at next_wakeup()); what the
// plant wants said and done goes to the owner's PlantPort at once. No socket, no clock, no heap.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "romano/base/bytes.h"
#include "romano/base/random.h"
#include "romano/base/time.h"
#include "romano/control/delay_meter.h"
#include "romano/control/messages.h"
#include "romano/mqttsn/types.h"

namespace romano::control {

/// What the plant's owner lends it for the time of a call. It does not call the plant from here.
class PlantPort {
public:
    /// To that robot's id topic. A message that cannot be sent is lost. The octets are valid during
    /// the call.
    virtual void publish(const RomanoId& to, Bytes message, mqttsn::Qos qos) = 0;

    /// Writes what the channel's sensor says to the front of `room` and returns its size.
    virtual std::size_t sense(Channel channel, MutableBytes room) = 0;
    /// A command that is young enough, once, in order.
    virtual void carry_out(Channel channel, Bytes value) = 0;
    /// There is no such command now: once, until the next carry_out().
    virtual void fall_back(Channel channel, Fallback fallback) = 0;

    /// The robot's own judgement on a loop that is possible.
    virtual bool may_open(const Open& open) {
        (void)open;
        return true;
    }
    virtual void on_state(Channel channel, State state, Reason reason) {
        (void)channel, (void)state, (void)reason;
    }

protected:
    ~PlantPort() = default;
};

/// One channel's loop.
class PlantLoop {
public:
    /// Samples that can still be answered, so periods that a deadline can have.
    static constexpr std::uint32_t window = 32;
    static constexpr Duration invite_again{to_duration(std::chrono::seconds{1})};
    static constexpr int most_invitations = 5;  // that nobody answered

    [[nodiscard]] State state() const { return state_; }
    [[nodiscard]] const RomanoId& controller() const { return controller_; }
    [[nodiscard]] const LoopCounters& counters() const { return counters_; }
    [[nodiscard]] const Ages& ages() const { return meter_.ages(); }

private:
    friend class PlantCore;
    /// One call of the plant.
    struct Call {
        Instant now;
        PlantPort& port;
        const RomanoId& self;
        Channel channel;
    };

    void on_open(const Open& open, const Call& call);
    void on_renew(const RomanoId& asker, const Call& call);
    void on_answer(Reason reason, const Call& call);
    void on_command(const Command& command, const Call& call);
    void on_tick(const Call& call);
    [[nodiscard]] Instant next_wakeup() const;
    void end(Reason reason, const Call& call);
    void report(const RomanoId& to, Reason reason, const Call& call) const;
    [[nodiscard]] Reason objection_to(const Open& open, const Call& call) const;
    void begin_lease(Instant now);

    void enter(State state, Reason reason, const Call& call);
    void fall_back_if_due(const Call& call);
    void invite(const Call& call);
    void take_sample(const Call& call);
    [[nodiscard]] std::uint16_t age_of_last_command() const;
    /// The counter of what is wrong with it, or null.
    [[nodiscard]] std::uint32_t* flaw_of(const Command& command, Instant now);
    [[nodiscard]] bool is_sampling() const { return state_ >= State::waiting; }
    [[nodiscard]] Duration period() const {
        return to_duration(std::chrono::milliseconds{period_ms_});
    }
    [[nodiscard]] Duration deadline() const {
        return to_duration(std::chrono::milliseconds{deadline_ms_});
    }

    State state_ = State::free;
    Session session_ = Session::none;  // when free: the ticket; none: not drawn yet
    RomanoId controller_;
    RomanoId asker_;  // who is told what becomes of the loop
    Law law_{};
    std::uint16_t period_ms_ = 0;
    std::uint16_t deadline_ms_ = 0;
    std::uint16_t lease_s_ = 0;
    Fallback fallback_ = Fallback::stop;
    bool ends_then_ = false;
    std::array<std::uint8_t, most_parameters> parameters_{};
    std::size_t parameters_size_ = 0;

    int invitations_ = 0;
    Instant invite_at_ = never;
    Instant sample_at_ = never;
    Instant falls_back_at_ = never;  // while controlled: when the command in force is too old
    Instant lease_ends_at_ = never;
    Instant report_at_ = never;
    Instant reported_at_ = Instant::min();  // unasked

    std::uint32_t usable_ = 0;  // of the latest samples, so many may be answered; up to `window`
    std::array<Instant, window> sent_at_{};
    LoopCounters counters_;  // `samples` is the sequence of the next one, too
    DelayMeter meter_;
};

struct PlantOptions {
    RomanoId id;
    std::uint64_t seed = 0;  // of tickets: differs between robots, and between starts of one
};

struct PlantCounters {
    std::uint32_t malformed = 0;
    std::uint32_t foreign = 0;  // commands of no loop here
};

class PlantCore {
public:
    PlantCore(const PlantCore&) = delete;
    PlantCore& operator=(const PlantCore&) = delete;

    /// A ROMANO message for which is_of_a_loop(). What is meant for controllers is passed over, so
    /// that a robot that is both hands it to both.
    void on_message(Instant now, Bytes message, PlantPort& port);
    /// Early or repeated ticks are harmless.
    void on_tick(Instant now, PlantPort& port);
    /// `never` when nothing is due; may be in the past.
    [[nodiscard]] Instant next_wakeup() const;

    /// The robot wants its channel back.
    void end(Instant now, Channel channel, PlantPort& port);

    [[nodiscard]] std::span<const PlantLoop> loops() const { return loops_; }
    [[nodiscard]] const PlantCounters& counters() const { return counters_; }

protected:
    PlantCore(std::span<PlantLoop> loops, const PlantOptions& options);
    ~PlantCore() = default;

private:
    [[nodiscard]] PlantLoop* loop_of(Channel channel);
    [[nodiscard]] PlantLoop* loop_of(Session session);
    [[nodiscard]] PlantLoop::Call call_of(const PlantLoop& loop, Instant now,
                                          PlantPort& port) const;
    void on_ask(const Ask& ask, Instant now, PlantPort& port);
    void on_open(const Open& open, Instant now, PlantPort& port);
    void on_command(const Command& command, Instant now, PlantPort& port);
    /// To somebody who asks for what is not there.
    void deny(const RomanoId& asker, Channel channel, Session session, Reason reason,
              PlantPort& port) const;

    std::span<PlantLoop> loops_;
    PlantOptions options_;
    Random random_;
    PlantCounters counters_;
};

template <std::size_t Channels>
class Plant final : public PlantCore {
public:
    static_assert(Channels >= 1 && Channels <= 256);
    explicit Plant(const PlantOptions& options) : PlantCore(loops_, options) {}

private:
    std::array<PlantLoop, Channels> loops_;
};

}  // namespace romano::control
