// A LAN of network namespaces with one contestant on it: its infrastructure, then nodes, each on a
// machine of its own; and what they use meanwhile.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/ros/contestant.h"
#include "bench/ros/samples.h"
#include "bench/ros/tap.h"
#include "experiments/process/broker_process.h"
#include "experiments/process/lan.h"
#include "romano/base/time.h"

namespace romano::bench::ros {

/// Ctrl-C: whatever waits in a world throws, so that its processes and namespaces go.
void heed_interrupts();

struct NodeTask {
    std::string name;
    std::optional<std::string> publishes = std::nullopt;
    std::vector<std::string> subscribes = {};
    bool echo = false;
    double rate_per_s = 0;
    unsigned octets = 32;
};

/// Of a set of processes.
struct Usage {
    double cpu_s = 0;
    double rss_mib = 0;
};

class World {
public:
    /// Room for so many nodes. Nothing runs yet. Throws std::exception.
    World(Contestant contestant, int nodes, std::filesystem::path programs,
          const std::filesystem::path& scratch);

    /// Starts it all at once.
    void start_infrastructure();
    /// Waits until it serves; brokers until all have met. Throws when it does not.
    void await_infrastructure();
    /// The first process: rosmaster, mosquitto, or the broker of nodes 0, n, 2n...
    void kill_first_daemon();
    void start_first_daemon();

    /// Node `number`, from 0, on a machine of its own; in the place of an earlier one of that
    /// number. Returns the time at which it was started.
    Instant start_node(int number, const NodeTask& task);
    void kill_node(int number);
    /// When it heard its first message; empty: not yet.
    [[nodiscard]] std::optional<Instant> first_heard(int number) const;
    /// Throws when one of them hears nothing, or ends.
    void await_first(const std::vector<int>& numbers);
    /// False when it has heard nothing by then.
    bool await_first(int number, Duration patience);
    /// Lets everything run, and returns the packets since the last run: also the first ones of a
    /// node that was started in between.
    std::vector<Packet> run(Duration time);

    /// Ends all nodes, which then leave their samples.
    void stop_nodes();
    /// Of a node that was ended by stop_nodes().
    [[nodiscard]] std::vector<Sample> samples_of(int number) const;

    [[nodiscard]] Usage infrastructure_usage() const;
    [[nodiscard]] Usage node_usage() const;  // all of them
    [[nodiscard]] Usage usage_of_node(int number) const;
    [[nodiscard]] int host_of_node(int number) const;
    [[nodiscard]] bool is_of_a_node(int host) const { return host > contestant_.brokers; }
    [[nodiscard]] const Contestant& contestant() const { return contestant_; }

private:
    void start(std::size_t daemon);
    /// Throws when something has ended, or the person at the keyboard has had enough.
    void check() const;
    [[nodiscard]] std::filesystem::path file_of(int number, const char* what) const;

    Contestant contestant_;
    std::filesystem::path programs_;
    std::filesystem::path folder_;
    experiments::Lan lan_;
    Tap tap_;
    std::vector<Daemon> daemons_;
    std::vector<std::unique_ptr<experiments::BrokerProcess>> running_;  // as daemons_
    std::vector<std::unique_ptr<experiments::BrokerProcess>> nodes_;
};

}  // namespace romano::bench::ros
