#include "experiments/cli/results.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "experiments/sweep/results_folder.h"
#include "experiments/sweep/telling.h"
#include "experiments/sweep/text_file.h"

namespace romano::experiments {
namespace {

namespace fs = std::filesystem;

constexpr const char* report_examples = R"(Example:
  romano report results/demo       (writes report.html anew, and prints the table)
Exit code: 0; 1 when a run failed; 2 when there are no results.
)";
constexpr const char* merge_examples = R"(Examples:
  romano sweep FILE --shard 1/3    (on one machine; 2/3 and 3/3 on two others)
  romano merge results/demo results/demo-shards/*
A cell that several folders have is taken once: a run that succeeded before one that failed, else
from the first. What the merged folder has already stays, so that merging again adds what is new.
Exit code: 0; 1 when a run failed or a cell is missing; 2 when the folders are of different sweeps.
)";

Manifest manifest_in(const fs::path& folder) {
    const fs::path file = folder / "manifest.json";
    return parse_manifest(read_text(file), file.string());
}

int report(const fs::path& folder) {
    const Results results = read_results(folder);
    return tell(results.sweep, manifest_in(folder), results.rows, folder);
}

/// Whether the run is to take the place of what is there.
bool is_wanted(const RunRow& row, const RunRow* present) {
    return present == nullptr || (!present->ok() && row.ok());
}

int merge(const fs::path& into, const std::vector<fs::path>& shards) {
    std::vector<Results> parts;
    for (const fs::path& shard : shards) {
        parts.push_back(read_results(shard));
        if (is_same_experiment(parts.back().sweep, parts.front().sweep)) continue;
        throw SweepError("`" + shard.string() + "` and `" + shards.front().string() +
                         "` are results of different sweeps");
    }
    const Results& first = parts.front();
    ResultsFolder merged{into, first.sweep, false};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        std::vector<RunRow> wanted;
        std::ranges::copy_if(parts[i].rows, std::back_inserter(wanted), [&](const RunRow& row) {
            return is_wanted(row, merged.row_of(row.cell));
        });
        merged.take(wanted, shards[i]);
    }
    merged.set_in_order();
    const Manifest manifest = manifest_in(shards.front());
    write_text(into / "manifest.json", to_json(manifest, first.sweep));
    const int exit_code = tell(first.sweep, manifest, merged.rows(), into);
    std::vector<std::uint32_t> missing;
    for (const Cell& cell : first.sweep.cells) {
        if (merged.row_of(cell) == nullptr) missing.push_back(cell.number);
    }
    if (missing.empty()) return exit_code;
    std::printf("%zu of %zu cells were not run; the first is cell %u\n", missing.size(),
                first.sweep.cells.size(), missing.front());
    return 1;
}

}  // namespace

void add_report(CLI::App& program, int& exit_code) {
    auto folder = std::make_shared<fs::path>();
    CLI::App& command =
        *program.add_subcommand("report", "Make the report of a sweep's results again");
    command.add_option("FOLDER", *folder, "The results")->required();
    command.footer(report_examples);
    command.callback([folder, &exit_code] { exit_code = report(*folder); });
}

void add_merge(CLI::App& program, int& exit_code) {
    auto into = std::make_shared<fs::path>();
    auto shards = std::make_shared<std::vector<fs::path>>();
    CLI::App& command = *program.add_subcommand(
        "merge", "Make one result of the shards of a sweep, with one report");
    command.add_option("INTO", *into, "The folder of the whole")->required();
    command.add_option("SHARD", *shards, "Results of shards, or of any other part")->required();
    command.footer(merge_examples);
    command.callback([into, shards, &exit_code] { exit_code = merge(*into, *shards); });
}

}  // namespace romano::experiments
