#include "experiments/report/report.h"

#include <algorithm>
#include <set>
#include <sstream>

#include "experiments/measure/bootstrap.h"
#include "experiments/measure/percentile.h"
#include "experiments/report/certainty.h"
#include "experiments/report/configuration.h"
#include "experiments/report/figures.h"
#include "experiments/report/page.h"
#include "experiments/report/summary_table.h"

namespace romano::experiments {
namespace {

double total(std::span<const RunRow> rows, Measured RunRow::*value) {
    double sum = 0;
    for (const RunRow& row : rows) sum += (row.*value).value_or(0);
    return sum;
}

std::string tile(const char* mood, const std::string& number, const std::string& words) {
    return std::string{"<div class=\"tile "} + mood + "\"><b>" + html_text(number) + "</b><span>" +
           words + "</span></div>\n";
}

std::string whole(double number) {
    return number_text(Measured{number}, 0);
}

const char* zero_is_good(double number) {
    return number == 0 ? "good" : "bad";
}

std::string tiles_of(std::span<const RunRow> rows, double probe_per_s) {
    std::vector<RunRow> ok;
    std::ranges::copy_if(rows, std::back_inserter(ok), [](const RunRow& row) { return row.ok(); });
    const double failed = static_cast<double>(rows.size() - ok.size());
    const double lost = total(ok, &RunRow::acknowledged_but_lost_qos1) +
                        total(ok, &RunRow::acknowledged_but_lost_qos2);
    const double doubled = total(ok, &RunRow::duplicates_qos2);
    const double disordered =
        total(ok, &RunRow::out_of_order_qos1) + total(ok, &RunRow::out_of_order_qos2);
    const double again = total(ok, &RunRow::connects_after_fault) +
                         total(ok, &RunRow::registers_after_fault) +
                         total(ok, &RunRow::subscribes_after_fault);
    const double struck = total(ok, &RunRow::failover_clients);
    const double recovered = total(ok, &RunRow::failover_recovered_clients);
    std::vector<double> probed;
    std::vector<double> medians;
    std::vector<double> lasts;
    for (const RunRow& row : ok) {
        if (row.failover_probe_ms) probed.push_back(*row.failover_probe_ms);
        if (row.failover_p50_ms) medians.push_back(*row.failover_p50_ms);
        if (row.failover_last_ms) lasts.push_back(*row.failover_last_ms);
    }
    std::string html = "<div class=\"tiles\">\n";
    html +=
        tile(zero_is_good(failed), std::to_string(ok.size()) + " of " + std::to_string(rows.size()),
             "runs succeeded");
    html += tile(zero_is_good(lost), whole(lost),
                 "acknowledged messages lost, of " + whole(total(ok, &RunRow::acknowledged)) +
                     " acknowledged (QoS 1, 2)");
    html += tile(zero_is_good(doubled), whole(doubled), "QoS 2 messages delivered twice");
    html += tile(zero_is_good(disordered), whole(disordered), "QoS 1 and 2 messages out of order");
    if (struck > 0) {
        html +=
            tile(recovered == struck ? "good" : "bad", whole(recovered) + " of " + whole(struck),
                 "clients of a struck broker heard again at the same address");
        html += tile(zero_is_good(again), whole(again),
                     "times a client sent CONNECT, REGISTER or SUBSCRIBE after a fault");
        const Percentiles probe{std::move(probed)};
        if (probe.count() > 0) {
            html += tile("", number_text(probe.at(0.5), 0) + " ms",
                         "failover in the median run, by a probe of " + csv_number(probe_per_s) +
                             " messages a second; the slowest run took " +
                             number_text(probe.max(), 0) + " ms");
        } else {
            html += tile("", number_text(Percentiles{medians}.at(0.5), 0) + " ms",
                         "until the median robot of the median run heard again, of which up to " +
                             publishing_interval_of(ok) +
                             " is the wait for a message to be published; the slowest took " +
                             number_text(Percentiles{lasts}.max(), 0) + " ms");
        }
    }
    return html + "</div>\n";
}

/// Nobody reads more, and browsers get slow.
constexpr std::size_t most_rows = 500;

std::string failures_of(std::span<const RunRow> rows) {
    std::string html;
    std::size_t failed = 0;
    for (const RunRow& row : rows) {
        const std::string why = row.ok() ? row.broken_promises() : row.status;
        if (why.empty() || ++failed > most_rows) continue;
        html += "<li>Cell " + std::to_string(row.cell.number) + " (" +
                html_text(describe(row.cell)) + "): " + html_text(why) + "</li>\n";
    }
    if (failed > most_rows) {
        html += "<li>and " + std::to_string(failed - most_rows) +
                " more, in <code>runs.csv</code></li>\n";
    }
    return html.empty() ? html : "<h2>Runs that failed</h2>\n<ul>\n" + html + "</ul>\n";
}

/// Beyond a few milliseconds the machine was too busy for its numbers to mean much.
std::string worst_lag_of(std::span<const RunRow> rows) {
    std::vector<double> lags;
    for (const RunRow& row : rows) {
        if (row.publish_lag_max_ms) lags.push_back(*row.publish_lag_max_ms);
    }
    return number_text(Percentiles{std::move(lags)}.max(), 1) + " ms behind schedule";
}

/// Says nothing when no configuration was run twice.
std::string certainty_section(std::span<const Configuration> configurations) {
    const SummaryTable table = certainty_of(configurations, most_rows);
    if (table.rows.empty()) return "";
    return "<h2>How sure the numbers are</h2>\n<div class=\"wide\">\n" + to_html(table) +
           "</div>\n<p class=\"how\">Means over the runs of a configuration, with the interval "
           "that "
           "covers the true mean in 95 of 100 such sweeps (bootstrap), and the runs that an "
           "interval of 10 % to either side takes (<code>repetitions</code> in the sweep "
           "file). With fewer than " +
           std::to_string(runs_for_an_interval) + " runs the intervals are rough. " +
           (table.rows.size() == most_rows
                ? "The table ends after " + std::to_string(most_rows) + " configurations. "
                : "") +
           "<code>romano compare</code> sets two results beside "
           "each "
           "other.</p>\n";
}

std::string link_text(const SimulatedLink& link) {
    const std::string least = csv_number(link.delay_min_ms);
    const std::string most = csv_number(link.delay_max_ms);
    return (least == most ? most : least + " to " + most) + " ms and lose " +
           csv_number(link.loss_percent) + " %";
}

/// The backbones of the cells, and what they do.
std::string backbones_text(const Sweep& sweep) {
    if (!is_in_virtual_time(sweep.settings.world)) return "";
    std::set<std::string> names;
    for (const Cell& cell : sweep.cells) names.insert(cell.backbone);
    std::string text;
    const auto add = [&](const char* name, const std::string& what) {
        if (names.contains(name)) text += (text.empty() ? "" : "; ") + what;
    };
    add("wire", "links between brokers on a wire take " + link_text(sweep.settings.wire));
    add("wifi", "on Wi-Fi " + link_text(sweep.settings.wifi));
    add("radio",
        "on radio brokers talk on channel 11, in broadcasts and unicasts of IEEE 802.15.4");
    return text.empty() ? "" : "; " + text;
}

/// The lines of the cells: "115200 baud or none".
std::string bauds_text(const Sweep& sweep, std::string Cell::*baud) {
    std::vector<std::string> texts;
    for (const Cell& cell : sweep.cells) {
        const std::string text = cell.*baud == "none" ? "none" : cell.*baud + " baud";
        if (std::ranges::find(texts, text) == texts.end()) texts.push_back(text);
    }
    std::string text;
    for (const std::string& one : texts) text += (text.empty() ? "" : " or ") + one;
    return text;
}

/// The radio cells.
std::string cells_text(const Sweep& sweep) {
    const SweptRadio& radio = sweep.settings.radio;
    return "; each broker's cell has a border router (UART: " +
           bauds_text(sweep, &Cell::router_baud) +
           "; the robots': " + bauds_text(sweep, &Cell::robot_baud) + "), " +
           csv_number(radio.router_distance_m) + " m from the next one, on " +
           std::to_string(radio.channels) + " channels in turn" + backbones_text(sweep);
}

std::string virtual_time() {
    return "the shipped cores of brokers and robots in virtual time, in which what a core computes "
           "takes no time";
}

/// What the cells ran in.
std::string world_text(const Sweep& sweep, const Manifest& manifest) {
    const SweepSettings& settings = sweep.settings;
    switch (settings.world) {
        case World::processes:
            if (manifest.hosts.empty()) {
                return "real brokers and real MQTT-SN robots over UDP on one host";
            }
            return "real brokers on " + std::to_string(manifest.hosts.size()) +
                   (manifest.hosts.size() == 1 ? " host" : " hosts") +
                   " and real MQTT-SN robots on another machine, over UDP";
        case World::simulated:
            return "simulated, " + virtual_time() + "; links between robots and brokers take " +
                   link_text(settings.client_link) + backbones_text(sweep);
        case World::radio:
            return "on modelled IEEE 802.15.4, " + virtual_time() + cells_text(sweep);
        case World::air:
            return "real brokers and real MQTT-SN robots on one host, with modelled IEEE 802.15.4 "
                   "between them in real time" +
                   cells_text(sweep);
    }
    return "";
}

/// Says nothing when the brokers ran beside the robots.
std::string hosts_section(const Manifest& manifest) {
    if (manifest.hosts.empty()) return "";
    SummaryTable table{
        .head = {"host", "addresses of brokers", "processor", "broker"}, .units = {}, .rows = {}};
    for (const BrokerHost& host : manifest.hosts) {
        std::string addresses;
        for (const std::string& address : host.addresses) {
            addresses += (addresses.empty() ? "" : " ") + address;
        }
        table.rows.push_back({host.name, addresses, host.architecture, host.broker_version});
    }
    return "<h2>Hosts of the brokers</h2>\n<div class=\"wide\">\n" + to_html(table) +
           "</div>\n<p class=\"how\">The robots ran on the machine below; <code>hosts.json</code> "
           "has what each host said of itself.</p>\n";
}

std::string setting(const char* name, const std::string& value) {
    return std::string{"<dt>"} + name + "</dt><dd>" + html_text(value) + "</dd>\n";
}

}  // namespace

std::string report_of(const Sweep& sweep, const Manifest& manifest, std::span<const RunRow> rows,
                      const std::filesystem::path& results) {
    const auto configurations = configurations_of(rows);
    std::ostringstream html;
    html << page_begin(sweep.settings.name) << "<p class=\"sub\">Sweep <b>"
         << html_text(sweep.settings.name) << "</b>, " << rows.size() << " of "
         << sweep.cells.size() << " cells: " << world_text(sweep, manifest)
         << "; traffic pattern <b>" << name_of(sweep.settings.pattern) << "</b>. "
         << html_text(manifest.started_utc) << "</p>\n"
         << tiles_of(rows, sweep.settings.probe_per_s);

    int number = 0;
    for (const Figure& figure : figures_of(configurations, sweep.settings, results)) {
        html << "<h2>" << ++number << ". " << html_text(figure.title) << "</h2>\n"
             << to_html(figure, results / "plots");
    }

    html << "<h2>Summary</h2>\n<div class=\"wide\">\n"
         << to_html(first_rows(summary_of(configurations), most_rows))
         << "</div>\n<p class=\"how\">"
         << (configurations.size() > most_rows
                 ? "The first " + std::to_string(most_rows) + " of " +
                       std::to_string(configurations.size()) +
                       " configurations; <code>summary.csv</code> has all. "
                 : "")
         << "Medians over the runs of a configuration; losses, duplicates "
            "and <em>again</em> are sums. <em>lost, acked</em>: QoS 1 and 2 messages that were "
            "acknowledged to their publisher and did not reach a subscriber. <em>failover</em>: "
            "by the probe, from the quickest run to the slowest, if there was one; of robots: from "
            "the first to the last client of the struck broker, no finer than their publishing "
            "interval. <em>leaderless</em>: longest. "
            "<em>again</em>: CONNECT, REGISTER and SUBSCRIBE messages that clients sent after the "
            "fault. <em>overhead</em>: between brokers, all together.</p>\n"
         << certainty_section(configurations) << failures_of(rows);

    const Machine& machine = manifest.machine;
    html << hosts_section(manifest) << "<h2>Machine and build</h2>\n<dl>\n"
         << setting("CPU", machine.cpu) << setting("Cores", std::to_string(machine.cores))
         << setting("Memory", number_text(Measured{machine.memory_gib}, 1) + " GiB")
         << setting("Load average before", number_text(Measured{machine.load_average}, 2))
         << setting("Load generator's worst delay", worst_lag_of(rows))
         << setting("System", machine.system + ", " + machine.kernel)
         << setting("Commit", std::string{manifest.build.commit})
         << setting("Compiler",
                    std::string{manifest.build.compiler} + ", " + std::string{manifest.build.type})
         << "</dl>\n<h2>Run it again</h2>\n<p>The whole sweep, or one of its cells alone (here the "
            "first):</p>\n<pre>"
         << html_text(run_command(manifest)) << " --fresh\n"
         << html_text(rerun_command(manifest, sweep.cells.front()))
         << "</pre>\n<p>Beside this file: <code>runs.csv</code> (one row a run), "
            "<code>summary.csv</code> (one row a configuration), <code>samples/</code> (every "
            "message), <code>traces/</code> (what the brokers said), "
            "<code>plots/</code> (gnuplot scripts with their numbers), "
            "<code>manifest.json</code>.</p>\n<p>The sweep file:</p>\n<pre>"
         << html_text(sweep.text) << "</pre>\n"
         << page_end;
    return html.str();
}

}  // namespace romano::experiments
