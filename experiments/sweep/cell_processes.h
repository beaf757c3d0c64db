// Runs of cells in processes of their own, several at once: no run has a part in another, and one
// that crashes is a failed run and not the end of the sweep. For worlds that share no place on
// this machine.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "experiments/sweep/run_row.h"

namespace romano::experiments {

struct CellProcesses {
    using Tell = std::function<void(double share, std::string_view doing)>;

    unsigned at_once = 1;
    /// Called in the cell's own process. `tell` is told how far it is.
    std::function<RunRow(const Cell& cell, const Tell& tell)> run;
    /// Called as runs end, in any order.
    std::function<void(const RunRow& row)> on_row;
    /// `share` of so many cells that are under way is over, all together.
    Tell on_progress;
    std::function<bool()> is_interrupted;

    /// False when it was interrupted: there are no rows of what was under way.
    [[nodiscard]] bool run_all(std::span<const Cell> cells) const;
};

}  // namespace romano::experiments
