#include "bench/cluster/cost.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <thread>

#include "bench/failover/cluster.h"
#include "bench/fleet.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "experiments/load/load_run.h"
#include "experiments/load/mqttsn_clients.h"
#include "experiments/measure/percentile.h"
#include "experiments/process/process_usage.h"
#include "experiments/sweep/csv.h"
#include "experiments/watch/metrics_fetch.h"
#include "experiments/watch/metrics_page.h"

namespace romano::bench {
namespace {

using namespace std::chrono_literals;
using experiments::LoadPlan;
using mqttsn::Qos;

constexpr std::size_t last = 2;           // of three brokers
constexpr Duration orphaned_for = 100ms;  // after the kill, about
constexpr double detection_time = 50;     // ms, of the profile `lan`

double in_ms(Duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

void await_whole(Cluster& cluster) {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    for (cluster.look(); !cluster.is_whole(); cluster.look()) {
        if (std::chrono::steady_clock::now() > deadline) {
            throw std::runtime_error("the brokers were not in one view within 20 s");
        }
        std::this_thread::sleep_for(5ms);
    }
}

double cpu_s(const Cluster& cluster, std::size_t broker) {
    const auto usage = experiments::usage_of(cluster.process(broker));
    return usage ? usage->cpu_s : 0;
}

double cpu_s(const Cluster& cluster) {
    double sum = 0;
    for (std::size_t i = 0; i < cluster.size(); ++i) sum += cpu_s(cluster, i);
    return sum;
}

double longest_turn_ms(const Cluster& cluster) {
    double longest_s = 0;
    for (std::size_t i = 0; i < cluster.size(); ++i) {
        const experiments::MetricsPage page{experiments::fetch_metrics(*cluster.metrics(i), 1s)};
        longest_s = std::max(longest_s, page.value("romano_longest_turn_seconds"));
    }
    return 1e3 * longest_s;
}

/// As experiments::MqttsnClients chooses it.
std::size_t home_of(const CostScenario& scenario, std::uint32_t subscriber) {
    return scenario.homes[(subscriber + 1) % scenario.homes.size()];
}

std::optional<double> value(const std::vector<CostRow>& rows, const std::string& scenario,
                            unsigned repetition, double CostRow::*field) {
    const auto row = std::ranges::find_if(rows, [&](const CostRow& each) {
        return each.scenario == scenario && each.repetition == repetition;
    });
    return row == rows.end() ? std::nullopt : std::optional{(*row).*field};
}

}  // namespace

std::vector<CostScenario> cost_scenarios(Duration measured) {
    LoadPlan loop{.publishers = 20, .subscribers = 20, .topics = 20, .qos = Qos::at_least_once};
    loop.in_flight = 80;
    loop.warm_up = 300ms;
    loop.duration = measured;
    loop.drain = 2s;
    LoadPlan paced = loop;
    paced.publishers = paced.subscribers = paced.topics = 5;
    paced.rate_per_s = 1000;
    LoadPlan qos0 = loop;
    qos0.publishers = qos0.subscribers = qos0.topics = 1;
    qos0.qos = Qos::at_most_once;
    qos0.in_flight = 64;
    LoadPlan many = loop;
    many.publishers = 20;  // nobody has more than 1,500 topic names
    many.subscribers = many.topics = 30'000;
    many.rate_per_s = 2000;
    many.warm_up = 61s;  // brokers forget the turns in which so many connected
    return {
        {"qos1_acks_0", loop, {0}, {"--acks", "0"}},
        {"qos1_acks_1", loop, {0}, {"--acks", "1"}},
        {"qos1_paced_acks_0", paced, {0}, {"--acks", "0"}},
        {"qos1_paced_acks_1", paced, {0}, {"--acks", "1"}},
        {"qos0_local", qos0, {0}, {}},
        {"qos0_between", qos0, {0, 1}, {}},
        {"qos1_paced_between", paced, {0, 1}, {}},
        {"qos1_acks_1_proven", loop, {0}, {"--acks", "1"}, {}, true},
        {"qos0_between_proven", qos0, {0, 1}, {}, {}, true},
        {"qos1_paced_between_proven", paced, {0, 1}, {}, {}, true},
        {"peer_stops_acks_1", paced, {0, 1}, {"--acks", "1"}, Fault::silence},
        {"peer_stops_acks_all", paced, {0, 1}, {"--acks", "all"}, Fault::silence},
        {.name = "peer_dies_many_sessions",
         .plan = many,
         .homes = {0, 1, 2},
         .broker_arguments = {"--max-sessions", "40000"},
         .fault = Fault::crash,
         .measures_turns = true,
         .when_asked_for = true,
         .publishers_at = last},  // the brokers that live
    };
}

CostRow run(const CostScenario& scenario, unsigned repetition, const Options& brokers) {
    Options options = brokers;
    options.brokers = 3;
    if (scenario.measures_turns) options.metrics_port = 9883;
    options.broker_arguments.insert(options.broker_arguments.end(),
                                    scenario.broker_arguments.begin(),
                                    scenario.broker_arguments.end());
    std::optional<Fleet> fleet;
    if (scenario.brokers_prove_themselves) {
        fleet.emplace(options.output / "fleet", std::vector<std::string>{"b1", "b2", "b3"}, 0);
    }
    Cluster cluster(options, options.output / "traces", fleet ? &*fleet : nullptr);
    await_whole(cluster);

    experiments::MqttsnOptions mqttsn{.brokers = {},
                                      .publishers_at = scenario.publishers_at,
                                      .sockets = experiments::SocketUse::shared,
                                      .timing = {.t_retry = 500ms, .t_wait = 1s, .n_retry = 20}};
    for (const std::size_t home : scenario.homes) {
        mqttsn.brokers.push_back(*net::parse_endpoint(cluster.address_text(home)));
    }
    experiments::MqttsnClients clients(scenario.plan, mqttsn);
    double cpu_before = 0;
    double cpu_after = 0;
    double cpu_of_the_dead = 0;
    std::optional<double> turn_ms;
    std::optional<MachineStalls> stalls;
    bool is_stopped = false;
    std::optional<Instant> killed_at;
    std::vector<double> orphans_delays_ms;
    experiments::LoadRun load(
        scenario.plan, clients,
        {.on_progress =
             [&](const std::string& phase, double share) {
                 if (scenario.measures_turns && !stalls && phase == "warming up") {
                     stalls.emplace();
                 }
                 const bool stop =
                     scenario.fault && phase == "measuring" && share > 1.0 / 3 && share < 2.0 / 3;
                 if (stop == is_stopped) return;
                 is_stopped = stop;
                 if (!stop) return cluster.revive(last);
                 if (scenario.fault != Fault::crash) {
                     return cluster.pause(last);
                 }
                 cpu_of_the_dead = cpu_s(cluster, last);
                 cluster.kill(last);
                 killed_at = net::now();
             },
         .on_measuring = [&] { cpu_before = cpu_s(cluster); },
         .on_measured =
             [&] {
                 cpu_after = cpu_s(cluster) + cpu_of_the_dead;
                 if (scenario.measures_turns) {
                     turn_ms = longest_turn_ms(cluster);
                 }
             },
         .is_stopped = {},
         .on_delivery =
             [&](std::uint32_t subscriber, Instant due, Duration delay) {
                 if (!killed_at || home_of(scenario, subscriber) != last) return;
                 if (due < *killed_at || due > *killed_at + orphaned_for) return;
                 orphans_delays_ms.push_back(in_ms(delay));
             }});
    const experiments::LoadFigures figures = load.run();
    return {
        .scenario = scenario.name,
        .repetition = repetition,
        .deliveries_per_s = figures.delivered_per_s(),
        .delivery_p50_ms = in_ms(figures.latency.at(0.5)),
        .delivery_max_ms = in_ms(figures.latency.max()),
        .acknowledgement_p50_ms = in_ms(figures.acknowledgement.at(0.5)),
        .acknowledgement_max_ms = in_ms(figures.acknowledgement.max()),
        .orphans_delivery_p50_ms = experiments::Percentiles{std::move(orphans_delays_ms)}.at(0.5),
        .longest_turn_ms = turn_ms,
        .machine_stalls = stalls ? stalls->seen() : std::nullopt,
        .broker_cpu_percent = 100 * (cpu_after - cpu_before) / figures.measured_s,
        .lost = static_cast<double>(figures.lost())};
}

std::vector<CostTarget> judge(const std::vector<CostRow>& rows) {
    std::vector<CostTarget> targets;
    const auto add = [&](const char* what, const char* wanted, bool at_most, double bound,
                         const std::function<std::optional<double>(unsigned)>& of) {
        std::vector<double> values;
        for (unsigned repetition = 1; repetition <= rows.size(); ++repetition) {
            if (const auto each = of(repetition)) values.push_back(*each);
        }
        if (values.empty()) return;
        const experiments::Percentiles all{std::move(values)};
        const double median = *all.at(0.5);
        targets.push_back({what, wanted, median, *all.min(), *all.max(),
                           at_most ? median <= bound : median >= bound});
    };
    const auto ratio = [&](const char* of, const char* to) {
        return [&rows, of, to](unsigned repetition) -> std::optional<double> {
            const auto a = value(rows, of, repetition, &CostRow::deliveries_per_s);
            const auto b = value(rows, to, repetition, &CostRow::deliveries_per_s);
            return a && b ? std::optional{*a / *b} : std::nullopt;
        };
    };
    const auto longest = [&](const char* of) {
        return [&rows, of](unsigned repetition) -> std::optional<double> {
            const auto acknowledged = value(rows, of, repetition, &CostRow::acknowledgement_max_ms);
            const auto delivered = value(rows, of, repetition, &CostRow::delivery_max_ms);
            return acknowledged ? std::optional{std::max(*acknowledged, *delivered)} : std::nullopt;
        };
    };
    add("QoS 1, acks 1 to acks 0, throughput", "at least 0.4", false, 0.4,
        ratio("qos1_acks_1", "qos1_acks_0"));
    add("QoS 1, acks 1, added latency p50 (ms)", "at most 1", true, 1,
        [&](unsigned repetition) -> std::optional<double> {
            const auto field = &CostRow::acknowledgement_p50_ms;
            const auto with = value(rows, "qos1_paced_acks_1", repetition, field);
            const auto without = value(rows, "qos1_paced_acks_0", repetition, field);
            return with && without ? std::optional{*with - *without} : std::nullopt;
        });
    add("QoS 0, between brokers to local, throughput", "at least 0.5", false, 0.5,
        ratio("qos0_between", "qos0_local"));
    add("QoS 1, acks 1, brokers that prove themselves to plain ones, throughput", "at least 0.6",
        false, 0.6, ratio("qos1_acks_1_proven", "qos1_acks_1"));
    add("QoS 0, between such brokers to plain ones, throughput", "at least 0.6", false, 0.6,
        ratio("qos0_between_proven", "qos0_between"));
    add("QoS 1, between such brokers to plain ones, latency p50", "at most 1.5", true, 1.5,
        [&](unsigned repetition) -> std::optional<double> {
            const auto field = &CostRow::delivery_p50_ms;
            const auto with = value(rows, "qos1_paced_between_proven", repetition, field);
            const auto without = value(rows, "qos1_paced_between", repetition, field);
            return with && without ? std::optional{*with / *without} : std::nullopt;
        });
    add("a peer stops, acks 1, longest delay (ms)", "at most 50", true, detection_time,
        longest("peer_stops_acks_1"));
    add("a peer stops, acks all, longest delay (ms)", "at most 50", true, detection_time,
        longest("peer_stops_acks_all"));
    const auto many = [&](const auto& figure) {
        return [&rows, figure](unsigned repetition) -> std::optional<double> {
            const auto row = std::ranges::find_if(rows, [&](const CostRow& each) {
                return each.orphans_delivery_p50_ms && each.repetition == repetition;
            });
            return row == rows.end() ? std::nullopt : std::optional<double>{figure(*row)};
        };
    };
    add("10,000 sessions lose their broker, delay p50 (ms)", "at most 30", true, 30,
        many([](const CostRow& row) { return *row.orphans_delivery_p50_ms; }));
    add("10,000 sessions there and back, longest delay (ms)", "at most 150", true, 150,
        many([](const CostRow& row) {
            return std::max(row.delivery_max_ms, row.acknowledgement_max_ms);
        }));
    add("10,000 sessions there and back, longest turn of a broker (ms)", "at most 10", true, 10,
        many([](const CostRow& row) { return *row.longest_turn_ms; }));
    return targets;
}

std::string csv_of(const std::vector<CostRow>& rows) {
    std::string text = experiments::csv_line(
        {"scenario", "repetition", "deliveries_per_s", "delivery_p50_ms", "delivery_max_ms",
         "acknowledgement_p50_ms", "acknowledgement_max_ms", "orphans_delivery_p50_ms",
         "longest_turn_ms", "longest_machine_stall_ms", "broker_cpu_percent", "lost"});
    for (const CostRow& row : rows) {
        const auto number = [](double each) { return experiments::csv_number(each); };
        text += experiments::csv_line(
            {row.scenario, std::to_string(row.repetition), number(row.deliveries_per_s),
             number(row.delivery_p50_ms), number(row.delivery_max_ms),
             number(row.acknowledgement_p50_ms), number(row.acknowledgement_max_ms),
             row.orphans_delivery_p50_ms ? number(*row.orphans_delivery_p50_ms) : std::string{},
             row.longest_turn_ms ? number(*row.longest_turn_ms) : std::string{},
             row.machine_stalls ? number(in_ms(row.machine_stalls->longest)) : std::string{},
             number(row.broker_cpu_percent), number(row.lost)});
    }
    return text;
}

}  // namespace romano::bench
