// A robot that controls others: it takes invitations, and answers each sample with what the
// application's law makes of it. README.md, "The controller".
//
// Shaped as the plant: messages and times in, calls of the owner's ControllerPort out.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/control/messages.h"
#include "romano/mqttsn/types.h"

namespace romano::control {

/// Names a loop among those of one controller, from 0, for tables of the application.
enum class Place : std::uint8_t {};

/// What the controller's owner lends it for the time of a call. It does not call the controller
/// from here.
class ControllerPort {
public:
    /// To that robot's id topic. The octets are valid during the call.
    virtual void publish(const RomanoId& to, Bytes message, mqttsn::Qos qos) = 0;

    /// False when there is no such law, or these parameters are none of it.
    virtual bool begin(Place place, const Invite& invite) = 0;
    /// The law: writes the command to the front of `room` and returns its size; nothing: this
    /// sample gets no command.
    virtual std::optional<std::size_t> control(Place place, const Sample& sample,
                                               MutableBytes room) = 0;
    /// The place is free: the plant said so, or is silent.
    virtual void on_end(Place place, Reason reason) { (void)place, (void)reason; }

protected:
    ~ControllerPort() = default;
};

struct ControllerCounters {
    std::uint32_t malformed = 0;
    std::uint32_t foreign = 0;  // samples of no loop here
    std::uint32_t refused = 0;  // invitations
};

struct SampleCounters {
    std::uint32_t samples = 0;   // handed to the law
    std::uint32_t missing = 0;   // between them
    std::uint32_t repeated = 0;  // or overtaken
    std::uint32_t jitter = 0;    // of their way, microseconds
};

class ControlledLoop {
public:
    /// Of a plant that is silent beside three periods.
    static constexpr Duration patience{to_duration(std::chrono::seconds{10})};

    [[nodiscard]] bool is_free() const { return session_ == Session::none; }
    [[nodiscard]] const RomanoId& plant() const { return plant_; }
    [[nodiscard]] const SampleCounters& counters() const { return counters_; }

private:
    friend class ControllerCore;
    [[nodiscard]] bool is_next(const Sample& sample) const;
    void measure(Instant now, const Sample& sample);
    void be_patient(Instant now);

    Session session_ = Session::none;  // none: the place is free
    RomanoId plant_;
    Channel channel_{};
    Duration period_{};
    Instant given_up_at_ = never;

    bool has_sample_ = false;
    std::uint32_t sequence_ = 0;  // of the latest sample, as its tick
    std::uint32_t tick_ = 0;
    Instant arrived_at_{};
    std::uint64_t jitter_16_ = 0;
    SampleCounters counters_;
};

class ControllerCore {
public:
    ControllerCore(const ControllerCore&) = delete;
    ControllerCore& operator=(const ControllerCore&) = delete;

    /// A ROMANO message for which is_of_a_loop(). What is meant for plants is passed over.
    void on_message(Instant now, Bytes message, ControllerPort& port);
    void on_tick(Instant now, ControllerPort& port);
    [[nodiscard]] Instant next_wakeup() const;

    /// It does not want to control any more: the plant is told, and falls back.
    void end(Place place, ControllerPort& port);

    [[nodiscard]] std::span<const ControlledLoop> loops() const { return loops_; }
    [[nodiscard]] const ControllerCounters& counters() const { return counters_; }

protected:
    ControllerCore(std::span<ControlledLoop> loops, const RomanoId& id) : loops_(loops), id_(id) {}
    ~ControllerCore() = default;

private:
    void on_invite(Instant now, const Invite& invite, ControllerPort& port);
    [[nodiscard]] Reason take(Instant now, const Invite& invite, ControllerPort& port);
    void on_sample(Instant now, const Sample& sample, ControllerPort& port);
    void on_bye(const Bye& bye, ControllerPort& port);
    void leave(ControlledLoop& loop, Reason reason, ControllerPort& port);
    [[nodiscard]] ControlledLoop* loop_of(Session session);
    [[nodiscard]] Place place_of(const ControlledLoop& loop) const {
        return Place{static_cast<std::uint8_t>(&loop - loops_.data())};
    }

    std::span<ControlledLoop> loops_;
    RomanoId id_;
    ControllerCounters counters_;
};

template <std::size_t Loops>
class Controller final : public ControllerCore {
public:
    static_assert(Loops >= 1 && Loops <= 256);
    explicit Controller(const RomanoId& id) : ControllerCore(loops_, id) {}

private:
    std::array<ControlledLoop, Loops> loops_;
};

}  // namespace romano::control
