// The world in which a cell runs: its time, its brokers, and room for robots. What a run does and
// measures is the same in each (cell_run.h). There are real processes on this machine
// (process_world.h), the same on machines of a testbed (testbed/testbed_world.h), and a simulator
// in virtual time (simulated_world.h). Robots are on modelled radio in two of them (radio_world.h,
// air_world.h).
//
// Brokers go by their numbers, from 0.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "experiments/process/process_usage.h"
#include "experiments/robots/surroundings.h"

namespace romano::experiments {

/// The run of a cell cannot go on: a sentence for its row.
struct RunFailed : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// One life of a broker, from its start to its end.
struct BrokerLife {
    std::string name;
    std::vector<std::string> arguments;  // of romano-broker; the world adds its own
    std::filesystem::path trace;         // for what it prints, if it prints
};

class CellWorld {
public:
    CellWorld() = default;
    virtual ~CellWorld() = default;
    CellWorld(const CellWorld&) = delete;
    CellWorld& operator=(const CellWorld&) = delete;

    [[nodiscard]] virtual Surroundings& surroundings() = 0;
    /// Of the robots, where they are elsewhere than who watches, probes and steers.
    [[nodiscard]] virtual Surroundings& robots() { return surroundings(); }
    [[nodiscard]] Instant now() { return surroundings().now(); }
    /// Date and time for people; empty where there is no calendar.
    [[nodiscard]] virtual std::string date() const = 0;

    /// Everything goes on until it is `done` or the deadline is there; true when `done`. `look` is
    /// called again and again meanwhile; what it throws ends the wait.
    virtual bool run_until(Instant deadline, const std::function<bool()>& done,
                           const std::function<void()>& look) = 0;
    /// What is about to happen at this moment has happened: it may refer to robots.
    virtual void finish_moment() = 0;

    [[nodiscard]] virtual BrokerAddress address_of(std::size_t broker) const = 0;
    /// Throws RunFailed.
    virtual void start(std::size_t broker, const BrokerLife& life) = 0;
    virtual void kill(std::size_t broker) = 0;         // kill -9
    virtual void ask_to_stop(std::size_t broker) = 0;  // SIGTERM
    virtual void pause(std::size_t broker) = 0;        // SIGSTOP
    virtual void resume(std::size_t broker) = 0;       // SIGCONT
    virtual void cut(std::size_t broker) = 0;          // the network of its machine
    virtual void mend(std::size_t broker) = 0;
    /// All are asked before anybody is waited for. Throws RunFailed when one cannot be stopped,
    /// because its machine is gone.
    virtual void stop_all() = 0;

    /// Throws RunFailed when what was measured is not what this world is meant to be.
    virtual void check_measured() {}

    [[nodiscard]] virtual bool has_ended(std::size_t broker) = 0;
    [[nodiscard]] virtual std::string how_it_ended(std::size_t broker) const = 0;
    /// Empty when it has ended, and where brokers are no processes.
    [[nodiscard]] virtual std::optional<ProcessUsage> usage_of(std::size_t broker) const = 0;
};

}  // namespace romano::experiments
