// One row of runs.csv: a cell and what its run measured. The table of columns is the file's
// format; experiments/README.md explains each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/sweep/cell.h"
#include "experiments/sweep/csv.h"

namespace romano::experiments {

using Measured = std::optional<double>;  // empty: the run had nothing to measure here

struct RunRow {
    Cell cell;
    std::string status = "ok";  // or the sentence that says why the run failed
    std::string started_utc;

    Measured run_s;  // from the first broker's start to the last one's end
    Measured published, acknowledged, unacknowledged, expected, delivered, delivery_ratio;
    Measured delivery_ratio_qos0, delivery_ratio_qos1, delivery_ratio_qos2;
    Measured acknowledged_but_lost_qos1, acknowledged_but_lost_qos2;
    Measured duplicates_qos0, duplicates_qos1, duplicates_qos2, stray_messages;
    Measured out_of_order_qos0, out_of_order_qos1, out_of_order_qos2;
    Measured delay_min_ms, delay_p50_ms, delay_p99_ms, delay_max_ms;
    Measured fan_out_p50_ms, fan_out_p99_ms, fan_out_max_ms;
    Measured publish_refused, publish_lag_max_ms;
    Measured strikes, failover_clients, failover_recovered_clients;
    Measured failover_first_ms, failover_p50_ms, failover_last_ms, failover_probe_ms;
    Measured without_leader_ms;
    Measured connects_after_fault, registers_after_fault, subscribes_after_fault;
    Measured interbroker_octets_per_s;
    Measured broker_cpu_percent_mean, broker_cpu_percent_max;
    Measured broker_rss_peak_mib_mean, broker_rss_peak_mib_max;

    [[nodiscard]] bool ok() const { return status == "ok"; }
    /// What the brokers promise and did not keep, as a sentence; empty when they kept it. With acks
    /// 0 they promise nothing for a crash.
    [[nodiscard]] std::string broken_promises() const;
};

[[nodiscard]] CsvRow run_columns();
[[nodiscard]] CsvRow to_csv(const RunRow& row);
/// Empty when `fields` are not a row under exactly run_columns().
[[nodiscard]] std::optional<RunRow> run_from_csv(const CsvRow& fields);

}  // namespace romano::experiments
