// The way of an experiment from its runs to its report, which `romano paper` and `romano loops`
// share: what is not done yet is run, several at once, with a bar; then the report is made of all.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "experiments/process/separate_runs.h"
#include "experiments/report/section.h"

namespace romano::experiments {

struct ReportRun {
    std::vector<std::string> parts;  // of the report, all that there are
    std::uint64_t seed = 1;
    unsigned jobs = 2;
    bool fresh = false;
    std::filesystem::path output;

    [[nodiscard]] bool wants(const char* part) const;
};

/// --parts, --seed, --jobs, --output and --fresh; what `run` has at first is the default.
void add_report_options(CLI::App& command, ReportRun& run);

using SectionsOf = std::function<std::vector<Section>(const std::filesystem::path& folder)>;

/// Prints the tables and where the report is; `sections_of` reads the folder of the runs' outcomes.
/// Throws std::runtime_error with a sentence.
void run_to_report(const ReportRun& run, const std::vector<SeparateRun>& runs,
                   const ReportHead& head, const SectionsOf& sections_of);

}  // namespace romano::experiments
