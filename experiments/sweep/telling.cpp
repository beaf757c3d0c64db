#include "experiments/sweep/telling.h"

#include <algorithm>
#include <cstdio>

#include "experiments/report/configuration.h"
#include "experiments/report/report.h"
#include "experiments/report/summary_table.h"
#include "experiments/sweep/text_file.h"

namespace romano::experiments {
namespace {

constexpr std::size_t most_told = 60;  // what somebody scrolls through

}  // namespace

int tell(const Sweep& sweep, const Manifest& manifest, std::span<const RunRow> rows,
         const std::filesystem::path& results) {
    const auto report = results / "report.html";
    write_text(report, report_of(sweep, manifest, rows, results));
    const SummaryTable table = summary_of(configurations_of(rows));
    write_text(results / "summary.csv", to_csv(table));
    if (!rows.empty()) std::printf("\n%s\n", to_text(first_rows(table, most_told)).c_str());
    if (table.rows.size() > most_told) {
        std::printf("The first %zu of %zu configurations; all of them: %s\n", most_told,
                    table.rows.size(), std::filesystem::absolute(results / "summary.csv").c_str());
    }
    std::printf("Report: %s\n", std::filesystem::absolute(report).c_str());
    return std::ranges::all_of(
               rows, [](const RunRow& row) { return row.ok() && row.broken_promises().empty(); })
               ? 0
               : 1;
}

}  // namespace romano::experiments
