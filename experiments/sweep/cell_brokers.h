// The brokers of one cell: real processes, each at an address of its own, started, struck, started
// again, and watched with their own eyes.
//
// They share this machine's loopback network; where the cell cuts networks, each is on a machine of
// its own (process/lan.h), and the robots on another.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/process/broker_process.h"
#include "experiments/process/lan.h"
#include "experiments/process/process_usage.h"
#include "experiments/sweep/place.h"
#include "experiments/sweep/results_folder.h"
#include "experiments/sweep/sweep_file.h"
#include "experiments/watch/broker_watch.h"

namespace romano::experiments {

/// The run of a cell cannot go on: a sentence for its row.
struct RunFailed : std::runtime_error {
    using std::runtime_error::runtime_error;
};

class CellBrokers {
public:
    struct Broker {
        std::string name;
        BrokerAddress address;
        std::unique_ptr<BrokerProcess> process;
        std::unique_ptr<BrokerWatch> watch;  // with this broker's eyes
        bool is_down = false;                // killed or stopped by us
        std::uint32_t lives = 0;
        std::uint64_t former_incarnation = 0;  // as last heard before it was started again

        /// What it used within the load, or until it was struck down for the first time.
        ProcessUsage usage_before;
        std::optional<ProcessUsage> usage;
        Instant usage_from{};
        Duration usage_time{};
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

    /// Throws RunFailed.
    CellBrokers(const SweepSettings& settings, const Cell& cell, const std::string& network,
                const std::filesystem::path& program, const ResultsFolder& results);

    [[nodiscard]] std::size_t size() const { return brokers_.size(); }
    [[nodiscard]] Broker& operator[](std::size_t number) { return brokers_[number]; }
    [[nodiscard]] const Broker& operator[](std::size_t number) const { return brokers_[number]; }
    [[nodiscard]] auto begin() { return brokers_.begin(); }
    [[nodiscard]] auto end() { return brokers_.end(); }
    [[nodiscard]] auto begin() const { return brokers_.begin(); }
    [[nodiscard]] auto end() const { return brokers_.end(); }
    [[nodiscard]] std::vector<BrokerAddress> addresses() const;

    /// `on_change` is called after each word of a broker on a broker.
    void watch(boost::asio::io_context& io, const std::function<void()>& on_change);
    /// Sockets that are made while it lives are where the robots are.
    [[nodiscard]] std::optional<Lan::On> where_robots_are() const;

    /// All live, in one view that all of them tell of, and each serves its own address.
    [[nodiscard]] bool are_whole() const;
    /// What each sees, when they are not.
    [[nodiscard]] std::string what_they_see() const;
    /// Who leads, by the word of the first that is up.
    [[nodiscard]] std::optional<std::size_t> leader() const;

    void start(std::size_t number);
    void kill(std::size_t number);
    void ask_to_stop(std::size_t number);
    void cut(std::size_t number) { lan_->cut(host_of(number)); }
    void mend(std::size_t number) { lan_->mend(host_of(number)); }
    /// All are asked before anybody is waited for.
    void stop_all();
    /// Throws RunFailed when one has ended by itself.
    void check();

    void begin_usage();
    void end_usage(std::size_t number);

private:
    [[nodiscard]] static int host_of(std::size_t number) { return static_cast<int>(number) + 1; }
    [[nodiscard]] std::string address_text(std::size_t number) const;
    [[nodiscard]] std::vector<std::string> arguments_of(std::size_t number) const;

    const SweepSettings& settings_;
    const Cell& cell_;
    const std::string& network_;
    const std::filesystem::path& program_;
    const ResultsFolder& results_;
    std::optional<DomainPlace> domain_;  // one broker needs none
    std::optional<Lan> lan_;
    std::vector<Broker> brokers_;
};

}  // namespace romano::experiments
