// A comparison for people and programs: a table for the terminal, a page with the figures overlaid,
// CSV and JSON.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "experiments/compare/comparison.h"
#include "experiments/report/summary_table.h"

namespace romano::experiments {

struct Compared {
    std::string name_a, name_b;  // the folders
    std::vector<Configuration> a, b;
    Comparison comparison;
    double confidence = 0.95;
};

/// A line a difference; without `all` only those in which B is better or worse.
[[nodiscard]] SummaryTable table_of(const Compared& compared, bool all);
/// What the table leaves out, and how to read it, in sentences.
[[nodiscard]] std::string verdict_of(const Compared& compared);

[[nodiscard]] std::string to_csv(const Compared& compared);
[[nodiscard]] std::string to_json(const Compared& compared);
/// Leaves the plots' scripts in `scripts`.
[[nodiscard]] std::string page_of(const Compared& compared, const std::filesystem::path& scripts);

}  // namespace romano::experiments
