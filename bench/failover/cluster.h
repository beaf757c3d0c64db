// The brokers under test: real processes, watched by what they print.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/failover/options.h"
#include "bench/failover/trace_tail.h"
#include "bench/fleet.h"
#include "experiments/process/broker_process.h"
#include "experiments/robots/socket_client.h"
#include "experiments/watch/metrics_fetch.h"

namespace romano::bench {

class Cluster {
public:
    /// Starts all brokers; what they print goes to files in `folder`. The fleet is null for plain
    /// listeners, and outlives this.
    Cluster(const Options& options, const std::filesystem::path& folder, const Fleet* fleet);
    ~Cluster();

    [[nodiscard]] std::size_t size() const { return brokers_.size(); }
    [[nodiscard]] const std::string& name(std::size_t broker) const {
        return brokers_[broker].name;
    }
    [[nodiscard]] experiments::BrokerAddress address(std::size_t broker) const;
    [[nodiscard]] std::string address_text(std::size_t broker) const;
    /// Where its page of metrics is; none when there are no such pages.
    [[nodiscard]] std::optional<experiments::MetricsAddress> metrics(std::size_t broker) const;
    /// With the scheme of its kind of listener in front.
    [[nodiscard]] std::string service_text(std::size_t broker) const;

    [[nodiscard]] pid_t process(std::size_t broker) const {
        return brokers_[broker].process->pid();
    }

    /// kill -9, without waiting for the end.
    void kill(std::size_t broker);
    void pause(std::size_t broker);
    /// Whatever befell it: it runs again.
    void revive(std::size_t broker);

    /// Reads the traces. Throws std::runtime_error when a broker ended by itself.
    void look();
    /// As of the last look(): all brokers are in one view of all, and serve their own addresses.
    [[nodiscard]] bool is_whole() const;
    /// As of the last look(): who leads the view of the first running broker.
    [[nodiscard]] std::optional<std::size_t> leader() const;
    [[nodiscard]] const TraceTail& trace(std::size_t broker) const {
        return brokers_[broker].trace;
    }

private:
    enum class State { running, killed, paused };
    struct Broker {
        std::string name;
        std::filesystem::path trace_file;
        TraceTail trace;
        std::unique_ptr<experiments::BrokerProcess> process;
        State state = State::running;
        Instant revived{};  // it must serve its address again after that
    };

    void start(std::size_t broker);
    [[nodiscard]] std::string host(std::size_t broker) const;
    [[nodiscard]] bool serves_its_address(std::size_t broker) const;

    Options options_;
    const Fleet* fleet_;
    std::vector<Broker> brokers_;
};

}  // namespace romano::bench
