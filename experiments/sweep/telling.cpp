#include "experiments/sweep/telling.h"

#include <algorithm>
#include <cstdio>

#include "experiments/report/configuration.h"
#include "experiments/report/report.h"
#include "experiments/report/summary_table.h"
#include "experiments/sweep/text_file.h"

namespace romano::experiments {

int tell(const Sweep& sweep, const Manifest& manifest, std::span<const RunRow> rows,
         const std::filesystem::path& results) {
    const auto report = results / "report.html";
    write_text(report, report_of(sweep, manifest, rows, results));
    if (!rows.empty()) {
        std::printf("\n%s\n", to_text(summary_of(configurations_of(rows))).c_str());
    }
    std::printf("Report: %s\n", std::filesystem::absolute(report).c_str());
    return std::ranges::all_of(
               rows, [](const RunRow& row) { return row.ok() && row.broken_promises().empty(); })
               ? 0
               : 1;
}

}  // namespace romano::experiments
