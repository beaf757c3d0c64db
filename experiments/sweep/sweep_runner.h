// A whole sweep: every cell that has no row yet, in order, then manifest, report and table.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "experiments/sweep/shard.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

struct SweepRequest {
    std::filesystem::path file;
    bool fresh = false;                          // forget earlier results
    bool retry_failed = false;                   // run cells again whose runs failed
    std::optional<std::uint32_t> only_cell;      // run this one again, into a folder of its own
    std::optional<Shard> shard;                  // its cells only, into a folder of its own
    bool replace = false;                        // but its row takes the place of the earlier one
    std::filesystem::path broker_program;        // romano-broker
    std::optional<std::filesystem::path> hosts;  // brokers on the machines of this hosts file
    std::optional<unsigned> jobs;                // simulated cells at once; else one for each core
};

/// The program's exit code: 0, 1 when runs failed, 130 after Ctrl-C. Throws SweepError before
/// anything has started.
int run_sweep(const SweepRequest& request);

}  // namespace romano::experiments
