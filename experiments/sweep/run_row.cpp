#include "experiments/sweep/run_row.h"

#include <charconv>
#include <string_view>
#include <utility>

namespace romano::experiments {
namespace {

struct MeasuredColumn {
    const char* name;
    Measured RunRow::*value;
};

constexpr MeasuredColumn measured_columns[] = {
    {"run_s", &RunRow::run_s},
    {"published_messages", &RunRow::published},
    {"acknowledged_messages", &RunRow::acknowledged},
    {"unacknowledged_messages", &RunRow::unacknowledged},
    {"expected_deliveries", &RunRow::expected},
    {"delivered", &RunRow::delivered},
    {"delivery_ratio", &RunRow::delivery_ratio},
    {"delivery_ratio_qos0", &RunRow::delivery_ratio_qos0},
    {"delivery_ratio_qos1", &RunRow::delivery_ratio_qos1},
    {"delivery_ratio_qos2", &RunRow::delivery_ratio_qos2},
    {"acknowledged_but_lost_qos1", &RunRow::acknowledged_but_lost_qos1},
    {"acknowledged_but_lost_qos2", &RunRow::acknowledged_but_lost_qos2},
    {"duplicates_qos0", &RunRow::duplicates_qos0},
    {"duplicates_qos1", &RunRow::duplicates_qos1},
    {"duplicates_qos2", &RunRow::duplicates_qos2},
    {"out_of_order_qos0", &RunRow::out_of_order_qos0},
    {"out_of_order_qos1", &RunRow::out_of_order_qos1},
    {"out_of_order_qos2", &RunRow::out_of_order_qos2},
    {"stray_messages", &RunRow::stray_messages},
    {"delay_min_ms", &RunRow::delay_min_ms},
    {"delay_p50_ms", &RunRow::delay_p50_ms},
    {"delay_p99_ms", &RunRow::delay_p99_ms},
    {"delay_max_ms", &RunRow::delay_max_ms},
    {"fan_out_p50_ms", &RunRow::fan_out_p50_ms},
    {"fan_out_p99_ms", &RunRow::fan_out_p99_ms},
    {"fan_out_max_ms", &RunRow::fan_out_max_ms},
    {"publish_refused", &RunRow::publish_refused},
    {"publish_lag_max_ms", &RunRow::publish_lag_max_ms},
    {"strikes", &RunRow::strikes},
    {"failover_clients", &RunRow::failover_clients},
    {"failover_recovered_clients", &RunRow::failover_recovered_clients},
    {"failover_first_ms", &RunRow::failover_first_ms},
    {"failover_p50_ms", &RunRow::failover_p50_ms},
    {"failover_last_ms", &RunRow::failover_last_ms},
    {"failover_probe_ms", &RunRow::failover_probe_ms},
    {"without_leader_ms", &RunRow::without_leader_ms},
    {"connects_after_fault", &RunRow::connects_after_fault},
    {"registers_after_fault", &RunRow::registers_after_fault},
    {"subscribes_after_fault", &RunRow::subscribes_after_fault},
    {"interbroker_octets_per_s", &RunRow::interbroker_octets_per_s},
    {"broker_cpu_percent_mean", &RunRow::broker_cpu_percent_mean},
    {"broker_cpu_percent_max", &RunRow::broker_cpu_percent_max},
    {"broker_rss_peak_mib_mean", &RunRow::broker_rss_peak_mib_mean},
    {"broker_rss_peak_mib_max", &RunRow::broker_rss_peak_mib_max},
};

constexpr const char* fixed_columns[] = {
    "cell",       "brokers",  "robots", "rate_per_s", "payload_octets", "qos",
    "elector",    "detector", "acks",   "clients",    "backbone",       "router_baud",
    "robot_baud", "fault",    "seed",   "repetition", "status",         "started_utc",
};

template <typename Number>
bool read_number(std::string_view field, Number& number) {
    const auto end = std::from_chars(field.data(), field.data() + field.size(), number);
    return end.ec == std::errc{} && end.ptr == field.data() + field.size();
}

}  // namespace

std::string RunRow::broken_promises() const {
    if (cell.acks == "0" && cell.fault != Fault::none) return "";
    constexpr std::pair<const char*, Measured RunRow::*> promises[] = {
        {"acknowledged messages of QoS 1 lost", &RunRow::acknowledged_but_lost_qos1},
        {"acknowledged messages of QoS 2 lost", &RunRow::acknowledged_but_lost_qos2},
        {"messages of QoS 2 delivered again", &RunRow::duplicates_qos2},
        {"messages of QoS 1 out of order", &RunRow::out_of_order_qos1},
        {"messages of QoS 2 out of order", &RunRow::out_of_order_qos2},
        {"messages to robots that should not have them", &RunRow::stray_messages},
    };
    std::string text;
    for (const auto& [what, value] : promises) {
        if ((this->*value).value_or(0) == 0) continue;
        text += (text.empty() ? "" : ", ") + csv_number(*(this->*value)) + " " + what;
    }
    return text;
}

CsvRow run_columns() {
    CsvRow names(std::begin(fixed_columns), std::end(fixed_columns));
    for (const MeasuredColumn& column : measured_columns) names.emplace_back(column.name);
    return names;
}

CsvRow to_csv(const RunRow& row) {
    const Cell& cell = row.cell;
    CsvRow fields = {std::to_string(cell.number),
                     std::to_string(cell.brokers),
                     std::to_string(cell.robots),
                     csv_number(cell.rate_per_s),
                     std::to_string(cell.payload_octets),
                     cell.qos.text(),
                     cell.elector,
                     cell.detector,
                     cell.acks,
                     cell.clients,
                     cell.backbone,
                     cell.router_baud,
                     cell.robot_baud,
                     std::string{name_of(cell.fault)},
                     std::to_string(cell.seed),
                     std::to_string(cell.repetition),
                     row.status,
                     row.started_utc};
    for (const MeasuredColumn& column : measured_columns) {
        const Measured& value = row.*column.value;
        fields.push_back(value ? csv_number(*value) : "");
    }
    return fields;
}

std::optional<RunRow> run_from_csv(const CsvRow& fields) {
    if (fields.size() != run_columns().size()) return std::nullopt;
    RunRow row;
    Cell& cell = row.cell;
    const auto qos = parse_qos_mix(fields[5]);
    const auto fault = fault_named(fields[13]);
    const bool fine =
        read_number(fields[0], cell.number) && read_number(fields[1], cell.brokers) &&
        read_number(fields[2], cell.robots) && read_number(fields[3], cell.rate_per_s) &&
        read_number(fields[4], cell.payload_octets) && qos && fault &&
        read_number(fields[14], cell.seed) && read_number(fields[15], cell.repetition);
    if (!fine) return std::nullopt;
    cell.qos = *qos;
    cell.elector = fields[6];
    cell.detector = fields[7];
    cell.acks = fields[8];
    cell.clients = fields[9];
    cell.backbone = fields[10];
    cell.router_baud = fields[11];
    cell.robot_baud = fields[12];
    cell.fault = *fault;
    row.status = fields[16];
    row.started_utc = fields[17];
    std::size_t at = std::size(fixed_columns);
    for (const MeasuredColumn& column : measured_columns) {
        const std::string& field = fields[at++];
        if (field.empty()) continue;
        row.*column.value = parse_csv_number(field);
        if (!(row.*column.value)) return std::nullopt;
    }
    return row;
}

}  // namespace romano::experiments
