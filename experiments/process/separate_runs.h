// Runs of an experiment in processes of their own, several at once: there is a core for each, and
// ns-3 has one simulator a process. A run leaves a file with its outcome when it is complete, so
// that what was interrupted goes on from there.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace romano::experiments {

struct SeparateRun {
    std::string name;                      // of its file: everything that the outcome depends on
    std::function<std::string()> outcome;  // called in the run's own process
    bool is_in_real_time = false;          // it has the machine to itself
};

[[nodiscard]] bool is_done(const SeparateRun& run, const std::filesystem::path& folder);

/// Does what has no file yet. `done` is called after each; throws when one fails.
void do_runs(const std::vector<SeparateRun>& runs, const std::filesystem::path& folder,
             unsigned jobs, const std::function<void(const SeparateRun&)>& done);

/// Of a run that is done.
[[nodiscard]] std::string outcome_of(const std::string& name, const std::filesystem::path& folder);

}  // namespace romano::experiments
