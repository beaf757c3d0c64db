// The table of a sweep, one line a configuration: for the terminal and for the report.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "experiments/report/configuration.h"

namespace romano::experiments {

struct SummaryTable {
    std::vector<std::string> head;
    std::vector<std::string> units;  // below the head; may be left out
    std::vector<std::vector<std::string>> rows;
};

/// Medians over the runs of a configuration; losses and duplicates are sums.
[[nodiscard]] SummaryTable summary_of(std::span<const Configuration> configurations);

/// Columns aligned with blanks, every line ended.
[[nodiscard]] std::string to_text(const SummaryTable& table);
[[nodiscard]] std::string to_html(const SummaryTable& table);
[[nodiscard]] std::string to_csv(const SummaryTable& table);

/// Without the rows behind the first `most`.
[[nodiscard]] SummaryTable first_rows(SummaryTable table, std::size_t most);

/// The characters that HTML gives a meaning, as text.
[[nodiscard]] std::string html_text(std::string_view text);

/// A number for people: three digits or so, "–" for nothing.
[[nodiscard]] std::string number_text(const Measured& number, int decimals);

}  // namespace romano::experiments
