// Comma-separated values as RFC 4180 has them: a field with a comma, a quote or a line break is
// quoted, and quotes inside are doubled. Lines end in \n.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace romano::experiments {

using CsvRow = std::vector<std::string>;

[[nodiscard]] std::string csv_line(const CsvRow& fields);

/// All rows of a text. A last row without its line break was cut off while it was written: it is
/// left out, so that an interrupted file reads as what was complete.
[[nodiscard]] std::vector<CsvRow> parse_csv(std::string_view text);

/// The shortest text that reads back as the same number.
[[nodiscard]] std::string csv_number(double number);
[[nodiscard]] std::optional<double> parse_csv_number(std::string_view field);

}  // namespace romano::experiments
