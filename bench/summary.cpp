#include "bench/summary.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>

#include "experiments/sweep/build_info.h"
#include "experiments/sweep/machine.h"

namespace romano::bench {
namespace {

struct Column {
    const char* name;
    Field field;
};
constexpr std::array columns{Column{"deliveries_per_s", &Row::deliveries_per_s},
                             Column{"latency_p50_us", &Row::p50_us},
                             Column{"latency_p99_us", &Row::p99_us},
                             Column{"cpu_us_per_message", &Row::cpu_us_a_message},
                             Column{"generator_cpu_percent", &Row::generator_cpu_percent},
                             Column{"lost_deliveries", &Row::lost},
                             Column{"duplicates", &Row::duplicates},
                             Column{"resident_start_kib", &Row::resident_start_kib},
                             Column{"resident_joined_kib", &Row::resident_joined_kib},
                             Column{"proportional_joined_kib", &Row::proportional_joined_kib},
                             Column{"anonymous_joined_kib", &Row::anonymous_joined_kib}};

template <typename... Values>
std::string line(const char* format, Values... values) {
    std::array<char, 320> text{};
    (void)std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

/// In the order in which they ran.
std::vector<std::string> different(const std::vector<Row>& rows, std::string Row::*which) {
    std::vector<std::string> names;
    for (const Row& row : rows) {
        if (std::ranges::find(names, row.*which) == names.end()) names.push_back(row.*which);
    }
    return names;
}

std::vector<double> list(const std::map<unsigned, double>& by_repetition) {
    std::vector<double> found;
    found.reserve(by_repetition.size());
    for (const auto& [repetition, value] : by_repetition) found.push_back(value);
    return found;
}

using Series = std::map<unsigned, double>;

/// Repetition by repetition, so that what slows both down slows neither in the ratio.
Series ratio(const Series& a, const Series& b) {
    Series found;
    for (const auto& [repetition, value] : a) {
        const auto other = b.find(repetition);
        if (other != b.end() && other->second != 0) found[repetition] = value / other->second;
    }
    return found;
}

enum class Wanted { at_least, at_most };

Target target(std::string what, Wanted wanted, double bound, const Series& series) {
    Target made{.what = std::move(what),
                .wanted = line(wanted == Wanted::at_least ? "at least %g" : "at most %g", bound),
                .measured = {}};
    if (series.empty()) return made;
    const std::vector<double> all = list(series);
    made.measured = median(all);
    made.low = *std::ranges::min_element(all);
    made.high = *std::ranges::max_element(all);
    made.holds = wanted == Wanted::at_least ? *made.measured >= bound : *made.measured <= bound;
    return made;
}

/// CPU time that each further subscriber of a message costs: least squares over the fan-outs.
Series fan_out_slope(const std::vector<Row>& rows, const std::string& contestant) {
    static const std::array<std::pair<const char*, double>, 4> fan_outs{
        {{"qos0_1_to_1", 1}, {"qos0_1_to_10", 10}, {"qos0_1_to_50", 50}, {"qos0_1_to_100", 100}}};
    std::map<unsigned, std::vector<std::pair<double, double>>> points;
    for (const auto& [scenario, subscribers] : fan_outs) {
        for (const auto& [repetition, cost] :
             values(rows, scenario, contestant, &Row::cpu_us_a_message)) {
            points[repetition].emplace_back(subscribers, cost);
        }
    }
    Series slopes;
    for (const auto& [repetition, line_points] : points) {
        if (line_points.size() != fan_outs.size()) continue;
        double x = 0;
        double y = 0;
        double xx = 0;
        double xy = 0;
        for (const auto& [subscribers, cost] : line_points) {
            x += subscribers;
            y += cost;
            xx += subscribers * subscribers;
            xy += subscribers * cost;
        }
        const auto n = static_cast<double>(line_points.size());
        slopes[repetition] = (n * xy - x * y) / (n * xx - x * x);
    }
    return slopes;
}

Series octets_a_session(const std::vector<Row>& rows) {
    Series found;
    for (const Row& row : rows) {
        if (row.scenario != "sessions_many" || row.contestant != "broker") continue;
        found[row.repetition] =
            (row.resident_joined_kib - row.resident_start_kib) * 1024 / row.sessions;
    }
    return found;
}

/// Of what it may take: 8 MB and 2.3 KB a session.
Series share_of_memory(const std::vector<Row>& rows, const std::string& with_keys, Field memory) {
    Series found;
    for (const Row& row : rows) {
        if (row.scenario != "sessions_with_keys" || row.contestant != with_keys) continue;
        found[row.repetition] = row.*memory / (8'192 + 2.3 * row.sessions);
    }
    return found;
}

Series lost_in_closed_loops(const std::vector<Row>& rows) {
    Series found;
    for (const Row& row : rows) {
        if (row.contestant == "broker" && !row.scenario.starts_with("rate_")) {
            found[row.repetition] += row.lost;
        }
    }
    return found;
}

}  // namespace

std::map<unsigned, double> values(const std::vector<Row>& rows, const std::string& scenario,
                                  const std::string& contestant, Field field) {
    Series found;
    for (const Row& row : rows) {
        if (row.scenario == scenario && row.contestant == contestant) {
            found[row.repetition] = row.*field;
        }
    }
    return found;
}

double median(std::vector<double> all) {
    if (all.empty()) return 0;
    std::ranges::sort(all);
    const std::size_t middle = all.size() / 2;
    return all.size() % 2 == 1 ? all[middle] : (all[middle - 1] + all[middle]) / 2;
}

std::vector<Target> judge(const std::vector<Row>& rows) {
    const auto to_reflector = [&](const char* scenario, Field field) {
        return ratio(values(rows, scenario, "broker", field),
                     values(rows, scenario, "reflector", field));
    };
    const Field throughput = &Row::deliveries_per_s;
    std::vector<Target> targets{
        target("throughput of the reflector's, QoS 0, 1 to 1", Wanted::at_least, 0.85,
               to_reflector("qos0_1_to_1", throughput)),
        target("throughput of the reflector's, QoS 0, 1 to 50", Wanted::at_least, 0.95,
               to_reflector("qos0_1_to_50", throughput)),
        target("throughput of the reflector's, QoS 1, 20 to 20", Wanted::at_least, 0.75,
               to_reflector("qos1_20_to_20", throughput)),
        target("throughput of the reflector's, QoS 2, 20 to 20", Wanted::at_least, 0.70,
               to_reflector("qos2_20_to_20", throughput)),
        target("CPU a further subscriber, of the reflector's", Wanted::at_most, 1.3,
               ratio(fan_out_slope(rows, "broker"), fan_out_slope(rows, "reflector"))),
        target("p99 at 10,000 messages/s, of the reflector's", Wanted::at_most, 2,
               to_reflector("rate_10000_per_s", &Row::p99_us)),
        target("throughput with many sessions, of that with 10", Wanted::at_least, 0.80,
               ratio(values(rows, "sessions_many", "broker", throughput),
                     values(rows, "sessions_10", "broker", throughput))),
        target("octets of memory a quiet session", Wanted::at_most, 2048, octets_a_session(rows)),
        target("deliveries lost in closed loops", Wanted::at_most, 0, lost_in_closed_loops(rows)),
    };
    const auto add = [&](const std::string& what, Wanted wanted, double bound, const char* scenario,
                         const std::string& contestant, const std::string& beside, Field field) {
        targets.push_back(target(what, wanted, bound,
                                 ratio(values(rows, scenario, contestant, field),
                                       values(rows, scenario, beside, field))));
    };
    for (const std::string with_keys : {"protected", "dtls"}) {
        add(with_keys + ", throughput of plain's, QoS 0, 1 to 1", Wanted::at_least, 0.75,
            "qos0_1_to_1", with_keys, "broker", throughput);
        add(with_keys + ", throughput of plain's, QoS 0, 1 to 50", Wanted::at_least, 0.60,
            "qos0_1_to_50", with_keys, "broker", throughput);
        add(with_keys + ", broker's CPU of plain's, QoS 0, 1 to 1", Wanted::at_most, 1 / 0.75,
            "qos0_1_to_1", with_keys, "broker", &Row::cpu_us_a_message);
        add(with_keys + ", broker's CPU of plain's, QoS 0, 1 to 50", Wanted::at_most, 1 / 0.60,
            "qos0_1_to_50", with_keys, "broker", &Row::cpu_us_a_message);
        for (const auto& [memory, field] :
             {std::pair{"resident", &Row::resident_joined_kib},
              std::pair{"proportional", &Row::proportional_joined_kib}}) {
            targets.push_back(target(with_keys + ", " + memory + " of 8 MB + 2.3 KB a session",
                                     Wanted::at_most, 1, share_of_memory(rows, with_keys, field)));
        }
    }
    struct Flooded {
        std::string what;
        std::string contestant;
        std::string beside;
    };
    for (const Flooded& each : {Flooded{"broker in a flood", "broker_flooded", "broker"},
                                Flooded{"CONNECTs in a client's name", "keys_flooded", "keys"},
                                Flooded{"protected in a flood", "protected_flooded", "protected"},
                                Flooded{"dtls in a flood", "dtls_flooded", "dtls"},
                                Flooded{"ClientHellos in a flood", "dtls_greeted", "dtls"}}) {
        for (const auto& [rate, scenario] :
             {std::pair{"1,000", "rate_1000_per_s"}, std::pair{"10,000", "rate_10000_per_s"}}) {
            add(each.what + ", p99 at " + rate + "/s of that without", Wanted::at_most, 2, scenario,
                each.contestant, each.beside, &Row::p99_us);
        }
    }
    return targets;
}

std::string table_of(const std::vector<Row>& rows) {
    std::string text =
        line("%-18s %-17s %12s %15s %10s %10s %10s %8s\n", "scenario", "contestant", "deliveries/s",
             "(least..most)", "p50 us", "p99 us", "CPU us/msg", "gen CPU");
    for (const std::string& scenario : different(rows, &Row::scenario)) {
        for (const std::string& contestant : different(rows, &Row::contestant)) {
            const auto of = [&](Field field) {
                return list(values(rows, scenario, contestant, field));
            };
            const std::vector<double> throughput = of(&Row::deliveries_per_s);
            if (throughput.empty()) continue;
            text +=
                line("%-18s %-17s %12.0f %7.0f..%-7.0f %9.1f %10.1f %10.2f %6.0f %%\n",
                     scenario.c_str(), contestant.c_str(), median(throughput),
                     *std::ranges::min_element(throughput), *std::ranges::max_element(throughput),
                     median(of(&Row::p50_us)), median(of(&Row::p99_us)),
                     median(of(&Row::cpu_us_a_message)), median(of(&Row::generator_cpu_percent)));
        }
    }
    return text;
}

std::string table_of(const std::vector<Target>& targets) {
    std::string text =
        line("%-50s %-14s %10s %21s\n", "target (broker)", "wanted", "median", "(least..most)");
    for (const Target& each : targets) {
        if (!each.measured) continue;
        text +=
            line("%-50s %-14s %10.3g %9.3g..%-9.3g  %s\n", each.what.c_str(), each.wanted.c_str(),
                 *each.measured, each.low, each.high, each.holds ? "holds" : "NOT REACHED");
    }
    return text;
}

std::string csv_of(const std::vector<Row>& rows) {
    std::string text = "scenario,contestant,repetition,sessions";
    for (const Column& column : columns) text += std::string{","} + column.name;
    text += "\n";
    for (const Row& row : rows) {
        text += row.scenario + "," + row.contestant + "," + std::to_string(row.repetition) + "," +
                std::to_string(row.sessions);
        for (const Column& column : columns) text += line(",%.9g", row.*column.field);
        text += "\n";
    }
    return text;
}

std::string json_of(const std::vector<Row>& rows, const std::vector<Target>& targets) {
    using Json = nlohmann::ordered_json;
    const experiments::Machine machine = experiments::this_machine();
    const experiments::BuildInfo build = experiments::build_info();
    Json json{
        {"commit", build.commit},
        {"compiler", build.compiler},
        {"build_type", build.type},
        {"machine", {{"cpu", machine.cpu}, {"cores", machine.cores}, {"kernel", machine.kernel}}},
        {"medians", Json::array()},
        {"targets", Json::array()}};
    for (const std::string& scenario : different(rows, &Row::scenario)) {
        for (const std::string& contestant : different(rows, &Row::contestant)) {
            Json each{{"scenario", scenario}, {"contestant", contestant}};
            bool found = false;
            for (const Column& column : columns) {
                const auto all = list(values(rows, scenario, contestant, column.field));
                found = found || !all.empty();
                each[column.name] = median(all);
            }
            if (found) json["medians"].push_back(std::move(each));
        }
    }
    for (const Target& each : targets) {
        if (!each.measured) continue;
        json["targets"].push_back({{"what", each.what},
                                   {"wanted", each.wanted},
                                   {"median", *each.measured},
                                   {"least", each.low},
                                   {"most", each.high},
                                   {"holds", each.holds}});
    }
    return json.dump(2) + "\n";
}

}  // namespace romano::bench
