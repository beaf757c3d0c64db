// One load from the first CONNECT to the figures: join, warm up, measure, drain, leave.
//
// At a rate the messages have a schedule and are timed from when they were due, so that a generator
// or a broker that lags behind does not hide it. In the closed loop a fixed number of messages is
// on its way; where one has arrived, the next leaves.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/load/arrivals.h"
#include "experiments/load/load_clients.h"
#include "experiments/load/load_figures.h"
#include "experiments/load/load_plan.h"

namespace romano::experiments {

/// The load could not be carried out: one sentence.
struct LoadError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Whom a run tells about itself; all may be empty.
struct LoadWatch {
    std::function<void(const std::string& phase, double share)> on_progress;
    std::function<void()> on_measuring;  // the measured time begins
    std::function<void()> on_measured;   // and is over
    std::function<bool()> is_stopped;    // an early end
    std::function<void()> on_turn = {};  // before each look at the sockets
    /// A message that was due then came to that subscriber.
    std::function<void(std::uint32_t subscriber, Instant due, Duration delay)> on_delivery = {};
    bool never_sleeps = false;  // a core for the generator, latencies without its wake-ups
};

class LoadRun : private LoadClients::Listener {
public:
    LoadRun(const LoadPlan& plan, LoadClients& clients, LoadWatch watch);

    /// Throws LoadError.
    [[nodiscard]] LoadFigures run();

private:
    using Number = LoadClients::Number;
    static constexpr std::uint32_t no_slot = 0xFFFFFFFF;

    /// A message of the closed loop that is on its way.
    struct Slot {
        std::uint32_t stream = 0;
        std::uint32_t sequence = 0;
        std::uint32_t missing = 0;  // deliveries, and the publisher's answer
        Instant sent_at = never;
    };
    struct Unanswered {
        LoadClients::PublishId publish;
        std::uint32_t slot;
        Instant due;
    };

    void join();
    [[noreturn]] void give_up(const std::string& why);
    void load();
    void load_until(Instant until, const char* phase);
    void drain();
    void turn(Instant until);
    void publish_due(Instant now, Instant until);
    void begin_loop();
    void fill(Instant now, std::uint32_t slot, std::uint32_t stream);
    void arrive(Instant now, std::uint32_t slot);
    [[nodiscard]] std::uint32_t stream_after(std::uint32_t stream) const;
    void write_off(Instant now);
    void publish(Instant now, std::uint32_t stream, Instant due, std::uint32_t slot);
    [[nodiscard]] bool is_settled() const;
    [[nodiscard]] bool is_stopped() const { return watch_.is_stopped && watch_.is_stopped(); }
    void tell(const char* phase, double share);

    void on_joined(Number client) override;
    void on_message(Instant now, Number client, Bytes payload, bool again) override;
    void on_published(Instant now, Number client, LoadClients::PublishId publish,
                      bool accepted) override;
    void on_trouble(Number client, const std::string& why) override;

    const LoadPlan& plan_;
    LoadClients& clients_;
    LoadWatch watch_;
    LoadFigures figures_;
    Arrivals arrivals_;

    Number begun_ = 0;
    Number joined_ = 0;
    std::string trouble_;
    Instant told_at_{};

    bool loading_ = false;
    bool measuring_ = false;
    Instant measured_from_ = never;
    Instant load_began_{};
    std::uint64_t scheduled_ = 0;
    Instant looked_at_{};
    std::vector<std::uint32_t> next_sequence_;         // by stream
    std::vector<std::vector<Unanswered>> unanswered_;  // by publisher
    std::vector<Slot> slots_;
    std::vector<std::uint8_t> payload_;
};

}  // namespace romano::experiments
