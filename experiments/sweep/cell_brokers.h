// The brokers of one cell, each at an address of its own: started, struck, started again, and
// watched with their own eyes. What they are made of is the world's matter.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/sweep/cell_world.h"
#include "experiments/sweep/sweep_file.h"
#include "experiments/watch/broker_watch.h"

namespace romano::experiments {

class CellBrokers {
public:
    struct Broker {
        std::string name;
        BrokerAddress address;
        std::string home;                    // that address as the broker is told it
        std::unique_ptr<BrokerWatch> watch;  // with this broker's eyes
        bool is_down = false;                // killed or stopped by us
        std::uint32_t lives = 0;
        std::uint64_t former_incarnation = 0;  // as last heard before it was started again

        /// What it used within the load, or until it was struck down for the first time.
        ProcessUsage usage_before;
        std::optional<ProcessUsage> usage;  // where there are processes
        Instant usage_from{};
        Duration usage_time{};
        bool is_measured = false;
        std::uint64_t octets_before = 0;
        std::uint64_t octets = 0;

        /// After the leader's death: when this broker was seen to follow a new one.
        std::optional<Instant> new_leader_at;

        /// The broker's own count, as fresh as its last word.
        [[nodiscard]] std::uint64_t octets_sent() const;
        /// It lives, in a view of so many, and serves its own address.
        [[nodiscard]] bool is_at_home_in_view_of(std::size_t members) const;

    private:
        [[nodiscard]] const BrokerStatus* own_status() const;
        friend class CellBrokers;
    };

    /// Where the trace of a broker of that name goes.
    using TraceOf = std::function<std::filesystem::path(const std::string& name)>;

    /// Throws RunFailed.
    CellBrokers(const SweepSettings& settings, const Cell& cell, CellWorld& world,
                TraceOf trace_of);

    [[nodiscard]] static std::string name_of(std::size_t number);
    /// The client id of who looks with that broker's eyes.
    [[nodiscard]] static std::string watch_of(std::size_t number);

    [[nodiscard]] std::size_t size() const { return brokers_.size(); }
    [[nodiscard]] Broker& operator[](std::size_t number) { return brokers_[number]; }
    [[nodiscard]] const Broker& operator[](std::size_t number) const { return brokers_[number]; }
    [[nodiscard]] auto begin() { return brokers_.begin(); }
    [[nodiscard]] auto end() { return brokers_.end(); }
    [[nodiscard]] auto begin() const { return brokers_.begin(); }
    [[nodiscard]] auto end() const { return brokers_.end(); }
    [[nodiscard]] std::vector<BrokerAddress> addresses() const;

    /// `on_change` is called after each word of a broker on a broker.
    void watch(const std::function<void()>& on_change);
    [[nodiscard]] CellWorld& world() { return world_; }

    /// All live, in one view that all of them tell of, and each serves its own address.
    [[nodiscard]] bool are_whole() const;
    /// What each sees, when they are not.
    [[nodiscard]] std::string what_they_see() const;
    /// Who leads, by the word of the first that is up.
    [[nodiscard]] std::optional<std::size_t> leader() const;

    void start(std::size_t number);
    void kill(std::size_t number);
    void ask_to_stop(std::size_t number);
    void stop_all();
    /// Throws RunFailed when one has ended by itself.
    void check();

    void begin_usage();
    void end_usage(std::size_t number);

private:
    [[nodiscard]] std::vector<std::string> arguments_of(std::size_t number) const;

    const SweepSettings& settings_;
    const Cell& cell_;
    CellWorld& world_;
    TraceOf trace_of_;
    std::vector<Broker> brokers_;
};

}  // namespace romano::experiments
