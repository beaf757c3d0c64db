#include "experiments/report/certainty.h"

#include "experiments/measure/bootstrap.h"

namespace romano::experiments {
namespace {

constexpr double confidence = 0.95;
constexpr double share = 0.1;

void append(std::vector<std::string>& row, const std::vector<double>& values, int decimals) {
    const auto interval = interval_of_mean(values, confidence);
    if (!interval) {
        row.insert(row.end(), {"–", "–", "–"});
        return;
    }
    const auto needed = runs_needed(values, share, confidence);
    row.push_back(number_text(mean_of(values), decimals));
    row.push_back(number_text(interval->low, decimals) + ".." +
                  number_text(interval->high, decimals));
    row.push_back(needed ? std::to_string(*needed) : "–");
}

}  // namespace

SummaryTable certainty_of(std::span<const Configuration> configurations, std::size_t most) {
    SummaryTable table{.head = {"configuration", "runs", "delay p99", "interval", "runs for ±10 %",
                                "failover", "interval", "runs for ±10 %"},
                       .units = {"", "", "ms", "ms", "", "ms", "ms", ""},
                       .rows = {}};
    const AxisLabels labels{configurations};
    for (const Configuration& each : configurations) {
        if (each.runs.size() < 2) continue;
        if (table.rows.size() == most) break;
        const auto probed = each.values(&RunRow::failover_probe_ms);
        const std::string label = labels.of(each.cell(), {});
        std::vector<std::string> row = {label.empty() ? describe(each.cell()) : label,
                                        std::to_string(each.runs.size())};
        append(row, each.values(&RunRow::delay_p99_ms), 1);
        append(row, probed.empty() ? each.values(&RunRow::failover_p50_ms) : probed, 0);
        table.rows.push_back(std::move(row));
    }
    return table;
}

}  // namespace romano::experiments
