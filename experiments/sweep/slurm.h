// A sweep on a computing cluster: its shards are the tasks of a job array, and a second job merges
// what they found when they have ended. Both scripts stay beside the shards, to be read and to be
// submitted again: cells that are done are not run twice.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace romano::experiments {

struct SlurmJobs {
    std::filesystem::path program;  // romano; on a path that all nodes have, as the files
    std::filesystem::path file;     // the sweep's
    std::filesystem::path output;   // of the whole
    std::filesystem::path broker_program;
    std::uint32_t shards = 1;
    std::vector<std::string> options;  // of sbatch, for the array: "--partition=short"
};

[[nodiscard]] std::string array_script(const SlurmJobs& jobs);
[[nodiscard]] std::string merge_script(const SlurmJobs& jobs);

/// Writes both and hands them to sbatch. Returns what to say to people. Throws SweepError with what
/// sbatch said when it refuses.
[[nodiscard]] std::string submit(const SlurmJobs& jobs);

}  // namespace romano::experiments
