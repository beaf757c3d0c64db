// Carries the fault of a cell out, step by step, while the robots go on talking; and keeps a note
// of each step, with the clock of the brokers' traces.
//
// Who is struck, and in which order, comes from the cell's seed.
#pragma once

#include <fstream>
#include <functional>
#include <vector>

#include "experiments/sweep/cell_brokers.h"
#include "romano/base/random.h"

namespace romano::experiments {

struct Strike {
    std::size_t broker;
    Instant at;
};

class FaultInjection {
public:
    /// Lets the robots run until it is `done` or the deadline; true when `done`.
    using RunUntil = std::function<bool(Instant deadline, const std::function<bool()>& done)>;

    FaultInjection(const SweepSettings& settings, const Cell& cell, CellBrokers& brokers,
                   std::ofstream notes, RunUntil run_until);

    /// Until `end`, or a little longer: what can be mended is whole again when it returns. Throws
    /// RunFailed when that does not come.
    void run(Instant end);

    [[nodiscard]] const std::vector<Strike>& strikes() const { return strikes_; }

private:
    void kill(std::size_t broker);
    void pause(std::size_t broker, Instant end);
    void cut(std::size_t broker, Instant end);
    void kill_all_but_one(Instant end);
    void replace_one_after_the_other(Instant end);

    [[nodiscard]] std::size_t leader() const;
    [[nodiscard]] std::size_t another_than_the_leader();
    [[nodiscard]] std::vector<std::size_t> in_any_order();
    Instant strike(std::size_t broker, const char* what);
    void note(Instant at, const std::string& what);
    void rest(Instant end);
    void await_whole();

    const SweepSettings& settings_;
    const Cell& cell_;
    CellBrokers& brokers_;
    CellWorld& world_;
    std::ofstream notes_;
    RunUntil run_until_;
    Random random_;
    std::vector<Strike> strikes_;
};

}  // namespace romano::experiments
