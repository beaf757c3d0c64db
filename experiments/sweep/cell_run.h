// One cell, run in its world: brokers, a swarm of robots, a fault in the middle, and what came of
// it.
//
//   start brokers → all in one view → robots join → load … fault … load → drain → measure → stop
#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/robots/failover_probe.h"
#include "experiments/robots/swarm.h"
#include "experiments/sweep/cell_brokers.h"
#include "experiments/sweep/cell_world.h"
#include "experiments/sweep/fault_injection.h"
#include "experiments/sweep/results_folder.h"
#include "experiments/sweep/run_row.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

/// Ctrl-C while a cell ran: there is no row of it.
struct Interrupted : std::runtime_error {
    Interrupted() : std::runtime_error("interrupted") {}
};

struct CellSurroundings {
    std::function<std::unique_ptr<CellWorld>(const Cell& cell)> make_world;  // throws RunFailed
    const ResultsFolder& results;
    /// Told what is going on, with the share of the cell that is over.
    std::function<void(double share, std::string_view doing)> on_progress;
    std::function<bool()> is_interrupted;
};

class CellRun {
public:
    CellRun(const SweepSettings& settings, const Cell& cell, const CellSurroundings& surroundings);
    ~CellRun();

    /// Always a row: when something fails, its status says what. Throws Interrupted only.
    RunRow run();

private:
    void start_brokers();
    void await_one_view();
    void join_robots();
    void load();
    void drain();
    void check_schedule() const;
    /// What goes wrong then is the row's status, unless it has one.
    void stop(RunRow& row);

    void measure_deliveries(RunRow& row) const;
    void measure_failover(RunRow& row) const;
    void measure_brokers(RunRow& row) const;

    void on_watch_change();
    void look_around();
    void sample_memory(Instant now);
    [[nodiscard]] double share_over() const;
    /// Runs the robots and watches until `done` or the deadline; true when `done`.
    bool run_until(Instant deadline, const std::function<bool()>& done);
    void run_for(Duration duration);

    const SweepSettings& settings_;
    const Cell& cell_;
    const CellSurroundings& surroundings_;
    std::unique_ptr<CellWorld> world_;
    std::unique_ptr<CellBrokers> brokers_;
    std::unique_ptr<Swarm> swarm_;
    std::unique_ptr<FailoverProbe> probe_;          // only where something fails, and if wanted
    std::unique_ptr<FaultInjection> fault_;         // while there was none: null
    std::vector<std::uint64_t> sent_before_fault_;  // by the types of again_types
    Duration load_time_{};
    bool is_loading_ = false;
    Instant next_memory_{};
    std::vector<MemorySample> memory_;
    std::string doing_;
    Instant begun_{};
    Instant checked_{};
};

}  // namespace romano::experiments
