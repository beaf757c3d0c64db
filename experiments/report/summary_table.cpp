#include "experiments/report/summary_table.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace romano::experiments {
namespace {

constexpr const char* nothing = "\u2013";

/// Characters, not octets: the dash has three.
std::size_t width_of(const std::string& text) {
    return static_cast<std::size_t>(
        std::ranges::count_if(text, [](char c) { return (c & '\xC0') != '\x80'; }));
}

std::string percent(const Measured& ratio) {
    // 99.996 % must not read as 100 %.
    if (ratio && *ratio < 1 && *ratio > 0.9999) return ">99.99";
    return number_text(ratio ? Measured{*ratio * 100} : ratio, ratio == 1.0 ? 0 : 2);
}

std::string range(const Measured& low, const Measured& high) {
    if (!low || !high) return nothing;
    return number_text(low, 0) + ".." + number_text(high, 0);
}

}  // namespace

std::string number_text(const Measured& number, int decimals) {
    if (!number) return nothing;
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), "%.*f", decimals, *number);
    const std::string_view written = text.data();
    const bool is_zero = written.find_first_not_of("-0.") == std::string_view::npos;
    return std::string{is_zero && written.starts_with('-') ? written.substr(1) : written};
}

SummaryTable summary_of(std::span<const Configuration> configurations) {
    SummaryTable table;
    constexpr std::array own_columns = {Axis::brokers, Axis::robots, Axis::fault};
    const AxisLabels labels{configurations};
    const bool extra = std::ranges::any_of(configurations, [&](const Configuration& each) {
        return !labels.of(each.cell(), own_columns).empty();
    });
    const auto column = [&table](const char* head, const char* unit) {
        table.head.emplace_back(head);
        table.units.emplace_back(unit);
    };
    column("brokers", "");
    column("robots", "");
    column("fault", "");
    if (extra) column("settings", "");
    column("runs", "ok/all");
    column("delivered", "%");
    column("lost", "acked");
    column("dup.", "QoS 2");
    column("order", "broken");
    column("delay", "p50 ms");
    column("delay", "p99 ms");
    const bool probed = std::ranges::any_of(configurations, [](const Configuration& each) {
        return each.of(&RunRow::failover_probe_ms).count() > 0;
    });
    if (probed) column("failover", "probe ms");
    column(probed ? "robots" : "failover", probed ? "hear, ms" : "ms");
    column("leaderless", "ms");
    column("again", "C+R+S");
    column("overhead", "kB/s");
    column("CPU", "%/broker");

    for (const Configuration& each : configurations) {
        const Cell& cell = each.cell();
        std::vector<std::string> row = {std::to_string(cell.brokers), std::to_string(cell.robots),
                                        std::string{name_of(cell.fault)}};
        if (extra) row.push_back(labels.of(cell, own_columns));
        const std::size_t all = each.runs.size() + each.failed.size();
        row.push_back(std::to_string(each.runs.size()) + "/" + std::to_string(all));
        const auto sum = [](const Measured& a, const Measured& b) -> Measured {
            if (!a && !b) return std::nullopt;
            return a.value_or(0) + b.value_or(0);
        };
        const Measured lost = sum(each.sum(&RunRow::acknowledged_but_lost_qos1),
                                  each.sum(&RunRow::acknowledged_but_lost_qos2));
        const Measured again = sum(
            sum(each.sum(&RunRow::connects_after_fault), each.sum(&RunRow::registers_after_fault)),
            each.sum(&RunRow::subscribes_after_fault));
        const Measured octets = each.median(&RunRow::interbroker_octets_per_s);
        row.push_back(percent(each.median(&RunRow::delivery_ratio)));
        row.push_back(number_text(lost, 0));
        row.push_back(number_text(each.sum(&RunRow::duplicates_qos2), 0));
        row.push_back(number_text(
            sum(each.sum(&RunRow::out_of_order_qos1), each.sum(&RunRow::out_of_order_qos2)), 0));
        row.push_back(number_text(each.median(&RunRow::delay_p50_ms), 2));
        row.push_back(number_text(each.median(&RunRow::delay_p99_ms), 1));
        if (probed) {
            const Percentiles probe = each.of(&RunRow::failover_probe_ms);
            row.push_back(range(probe.min(), probe.max()));
        }
        row.push_back(range(each.of(&RunRow::failover_first_ms).min(),
                            each.of(&RunRow::failover_last_ms).max()));
        row.push_back(number_text(each.of(&RunRow::without_leader_ms).max(), 0));
        row.push_back(number_text(again, 0));
        row.push_back(number_text(octets ? Measured{*octets / 1e3} : octets, 1));
        row.push_back(number_text(each.median(&RunRow::broker_cpu_percent_mean), 1));
        table.rows.push_back(std::move(row));
    }
    return table;
}

std::string to_text(const SummaryTable& table) {
    std::vector<std::size_t> widths(table.head.size(), 0);
    std::vector<std::vector<std::string>> lines = {table.head};
    if (!table.units.empty()) lines.push_back(table.units);
    const std::size_t head_lines = lines.size();
    lines.insert(lines.end(), table.rows.begin(), table.rows.end());
    for (const auto& line : lines) {
        for (std::size_t i = 0; i < line.size(); ++i) {
            widths[i] = std::max(widths[i], width_of(line[i]));
        }
    }
    std::string text;
    for (std::size_t number = 0; number < lines.size(); ++number) {
        for (std::size_t i = 0; i < lines[number].size(); ++i) {
            const std::string& field = lines[number][i];
            text += std::string(widths[i] - width_of(field) + (i == 0 ? 0 : 2), ' ') + field;
        }
        text += '\n';
        if (number + 1 == head_lines) {
            std::size_t whole = 2 * (widths.size() - 1);
            for (const std::size_t width : widths) whole += width;
            text += std::string(whole, '-') + '\n';
        }
    }
    return text;
}

std::string to_html(const SummaryTable& table) {
    std::string html = "<table>\n<thead><tr>";
    for (std::size_t i = 0; i < table.head.size(); ++i) {
        html += "<th>" + html_text(table.head[i]);
        if (!table.units.empty() && !table.units[i].empty())
            html += "<br><small>" + html_text(table.units[i]) + "</small>";
        html += "</th>";
    }
    html += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
        html += "<tr>";
        for (const std::string& field : row) html += "<td>" + html_text(field) + "</td>";
        html += "</tr>\n";
    }
    return html + "</tbody></table>\n";
}

std::string to_csv(const SummaryTable& table) {
    CsvRow head = table.head;
    for (std::size_t i = 0; i < table.units.size(); ++i) {
        if (!table.units[i].empty()) head[i] += " (" + table.units[i] + ")";
    }
    std::string csv = csv_line(head);
    for (const auto& row : table.rows) csv += csv_line(row);
    return csv;
}

SummaryTable first_rows(SummaryTable table, std::size_t most) {
    if (table.rows.size() > most) table.rows.resize(most);
    return table;
}

std::string html_text(std::string_view text) {
    std::string html;
    for (const char c : text) {
        switch (c) {
            case '&':
                html += "&amp;";
                break;
            case '<':
                html += "&lt;";
                break;
            case '>':
                html += "&gt;";
                break;
            case '"':
                html += "&quot;";
                break;
            default:
                html += c;
        }
    }
    return html;
}

}  // namespace romano::experiments
