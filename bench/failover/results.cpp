#include "bench/failover/results.h"

#include <array>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "experiments/measure/percentile.h"
#include "experiments/report/plot.h"
#include "experiments/sweep/build_info.h"
#include "experiments/sweep/csv.h"
#include "experiments/sweep/machine.h"

namespace romano::bench {
namespace {

using experiments::CsvRow;
using experiments::Percentiles;

struct Column {
    const char* name;
    const char* says;  // for people, and in the figure
    std::optional<double> (*of)(const Trial&);
};
constexpr std::array columns = {
    Column{"detect_ms", "detected", [](const Trial& t) { return t.parts.detect; }},
    Column{"agree_ms", "view agreed", [](const Trial& t) { return t.parts.agree; }},
    Column{"adopt_ms", "sessions adopted", [](const Trial& t) { return t.parts.adopt; }},
    Column{"address_ms", "address bound", [](const Trial& t) { return t.parts.address; }},
    Column{"deliver_ms", "first message", [](const Trial& t) { return t.parts.deliver; }},
};

std::string field(const std::optional<double>& value) {
    return value ? experiments::csv_number(*value) : "";
}

CsvRow head() {
    CsvRow row = {"trial", "victim", "led", "heir", "total_ms"};
    for (const Column& column : columns) row.emplace_back(column.name);
    row.insert(row.end(), {"return_ms", "connects", "registers", "subscribes", "handshakes"});
    return row;
}

CsvRow to_row(const Trial& trial) {
    CsvRow row = {std::to_string(trial.number), trial.victim, trial.led ? "yes" : "no", trial.heir,
                  field(trial.total_ms)};
    for (const Column& column : columns) row.push_back(field(column.of(trial)));
    row.insert(row.end(), {field(trial.return_ms), std::to_string(trial.connects),
                           std::to_string(trial.registers), std::to_string(trial.subscribes),
                           std::to_string(trial.handshakes)});
    return row;
}

Trial from_row(const CsvRow& row) {
    const auto number = [&](std::size_t at) { return experiments::parse_csv_number(row.at(at)); };
    const auto count = [&](std::size_t at) {
        return static_cast<std::uint64_t>(number(at).value_or(0));
    };
    Trial trial{.number = static_cast<std::uint32_t>(count(0)),
                .victim = row.at(1),
                .led = row.at(2) == "yes",
                .heir = row.at(3),
                .total_ms = number(4),
                .parts = {number(5), number(6), number(7), number(8), number(9)},
                .return_ms = number(10)};
    trial.connects = count(11);
    trial.registers = count(12);
    trial.subscribes = count(13);
    trial.handshakes = count(14);
    return trial;
}

std::string text_of(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

Percentiles percentiles_of(const std::vector<Trial>& trials,
                           const std::function<std::optional<double>(const Trial&)>& of) {
    std::vector<double> samples;
    for (const Trial& trial : trials) {
        if (const auto value = of(trial)) samples.push_back(*value);
    }
    return Percentiles{std::move(samples)};
}

nlohmann::ordered_json to_json(const Percentiles& p) {
    nlohmann::ordered_json json{{"count", p.count()}};
    if (p.count() == 0) return json;
    json.update({{"min", *p.min()},
                 {"p50", *p.at(0.5)},
                 {"p90", *p.at(0.9)},
                 {"p99", *p.at(0.99)},
                 {"max", *p.max()}});
    return json;
}

nlohmann::ordered_json settings_json(const Options& options) {
    return {{"brokers", options.brokers},
            {"fault", name_of(options.fault)},
            {"victim", name_of(options.victim)},
            {"listener", name_of(options.packets)},
            {"qos", options.qos},
            {"broker_arguments", options.broker_arguments}};
}

void print(const char* name, const Percentiles& p) {
    if (p.count() == 0) return;
    std::printf("%-18s %6zu %8.2f %8.2f %8.2f %8.2f %8.2f\n", name, p.count(), *p.min(), *p.at(0.5),
                *p.at(0.9), *p.at(0.99), *p.max());
}

void print(const Watched& watched) {
    const std::string fault =
        watched.away_s == 0 ? "" : ", a broker away for " + std::to_string(watched.away_s) + " s";
    std::printf(
        "%.0f s of full load%s, %.0f messages/s, %llu lost: %llu suspicions, %llu leases "
        "lost, %llu false failovers\n",
        watched.seconds, fault.c_str(), static_cast<double>(watched.messages) / watched.seconds,
        static_cast<unsigned long long>(watched.lost),
        static_cast<unsigned long long>(watched.suspicions),
        static_cast<unsigned long long>(watched.leases_lost),
        static_cast<unsigned long long>(watched.take_overs));
    std::printf("%s\n", text_of(watched.machine_stalls).c_str());
}

/// The share of trials in which it had happened by then.
experiments::PlotSeries distribution(const std::string& label, std::vector<double> samples) {
    std::sort(samples.begin(), samples.end());
    experiments::PlotSeries series{.label = label, .points = {}, .line = true, .small = true};
    for (std::size_t i = 0; i < samples.size(); ++i) {
        series.points.push_back(
            {.x = samples[i],
             .y = 100.0 * static_cast<double>(i + 1) / static_cast<double>(samples.size())});
    }
    return series;
}

experiments::Plot figure(const Options& options, const std::vector<Trial>& trials) {
    experiments::PlotPanel panel{
        .title = std::to_string(trials.size()) + " trials, " + std::to_string(options.brokers) +
                 " brokers, " + name_of(options.fault) + " of " +
                 (options.victim == Victim::leader ? "the leader" : "another than the leader"),
        .x_label = "time since the fault (ms)",
        .y_label = "trials in which it had happened (%)",
        .series = {},
        .ticks_at_points = false,
        .y_from = 0,
        .y_to = 100};
    std::vector<std::vector<double>> reached(columns.size());
    for (const Trial& trial : trials) {
        double since = 0;
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const auto part = columns[i].of(trial);
            if (!part) break;
            since += *part;
            reached[i].push_back(since);
        }
    }
    for (const std::size_t i : {0U, 1U, 3U, 4U}) {  // adopting takes no time that one could see
        panel.series.push_back(distribution(columns[i].says, reached[i]));
    }
    return {.name = "failover", .panels = {std::move(panel)}};
}

}  // namespace

Results::Results(const Options& options) : options_(options), file_(options.output / "trials.csv") {
    std::filesystem::create_directories(options.output);
    const auto settings_file = options.output / "settings.json";
    const std::string settings = settings_json(options).dump(2) + "\n";
    if (options.fresh) {
        std::filesystem::remove(file_);
        std::filesystem::remove_all(traces());
    }
    if (std::filesystem::exists(file_) && text_of(settings_file) != settings) {
        throw std::runtime_error("--output '" + options.output.string() +
                                 "': holds trials of other settings; give another folder, or "
                                 "--fresh to forget them");
    }
    const auto rows = experiments::parse_csv(text_of(file_));
    for (std::size_t i = 1; i < rows.size(); ++i) {
        if (rows[i].size() == head().size()) trials_.push_back(from_row(rows[i]));
    }
    // Written anew: a row that was cut off is gone.
    std::ofstream csv(file_);
    csv << experiments::csv_line(head());
    for (const Trial& trial : trials_) csv << experiments::csv_line(to_row(trial));
    std::ofstream(settings_file) << settings;
}

void Results::add(const Trial& trial) {
    trials_.push_back(trial);
    std::ofstream(file_, std::ios::app) << experiments::csv_line(to_row(trial));
}

void Results::conclude() const {
    const auto total = percentiles_of(trials_, [](const Trial& t) { return t.total_ms; });
    const auto returned = percentiles_of(trials_, [](const Trial& t) { return t.return_ms; });
    std::uint64_t noticed = 0;
    std::uint64_t handshakes = 0;
    for (const Trial& t : trials_) {
        noticed += t.connects + t.registers + t.subscribes;
        handshakes += t.handshakes;
    }

    std::printf("%-18s %6s %8s %8s %8s %8s %8s\n", "milliseconds", "trials", "min", "p50", "p90",
                "p99", "max");
    nlohmann::ordered_json parts = nlohmann::ordered_json::object();
    for (const Column& column : columns) {
        const auto part = percentiles_of(trials_, column.of);
        print(column.says, part);
        parts[column.name] = to_json(part);
    }
    print("failover", total);
    print("return", returned);
    const std::size_t silent = trials_.size() - total.count();
    std::printf(
        "CONNECT, REGISTER and SUBSCRIBE from the victims' clients: %llu; handshakes: %llu; trials "
        "without a message: %zu\n",
        static_cast<unsigned long long>(noticed), static_cast<unsigned long long>(handshakes),
        silent);

    const auto machine = experiments::this_machine();
    const auto build = experiments::build_info();
    nlohmann::ordered_json summary{
        {"settings", settings_json(options_)},
        {"commit", build.commit},
        {"build", build.type},
        {"machine", {{"cpu", machine.cpu}, {"cores", machine.cores}, {"kernel", machine.kernel}}},
        {"trials", trials_.size()},
        {"trials_without_message", silent},
        {"connects_registers_subscribes", noticed},
        {"handshakes", handshakes},
        {"failover_ms", to_json(total)},
        {"parts_ms", parts},
        {"return_ms", to_json(returned)}};
    if (watched_) {
        print(*watched_);
        summary["watch"] = {
            {"seconds", watched_->seconds},           {"away_seconds", watched_->away_s},
            {"messages", watched_->messages},         {"lost", watched_->lost},
            {"suspicions", watched_->suspicions},     {"leases_lost", watched_->leases_lost},
            {"false_failovers", watched_->take_overs}};
        if (const auto& stalls = watched_->machine_stalls) {
            summary["watch"]["machine_stalls"] = stalls->count;
            summary["watch"]["longest_machine_stall_ms"] =
                std::chrono::duration<double, std::milli>(stalls->longest).count();
        }
    }
    std::ofstream(options_.output / "summary.json") << summary.dump(2) << '\n';
    if (const auto svg = experiments::draw(figure(options_, trials_), options_.output)) {
        std::ofstream(options_.output / "failover.svg") << *svg << '\n';
    }
}

}  // namespace romano::bench
