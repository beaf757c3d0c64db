#include "bench/ros/tasks.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include "bench/ros/lowpan_cost.h"
#include "bench/ros/scratch.h"
#include "bench/ros/world.h"
#include "broker/net/clock.h"
#include "experiments/measure/percentile.h"

namespace romano::bench::ros {
namespace {

using namespace std::chrono_literals;
using experiments::Percentiles;

constexpr auto settling = 500ms;  // from the first message to the measurement
constexpr auto tail = 500ms;      // for the last messages of the measurement to arrive
constexpr int delay_rate_of_deaths = 100;

std::int64_t ns(Instant instant) {
    return instant.time_since_epoch().count();
}
double ms(std::int64_t nanoseconds) {
    return static_cast<double>(nanoseconds) * 1e-6;
}

/// So many machines in a folder of their own.
struct Stage {
    Stage(const Contestant& contestant, const Plan& plan, const std::string& task, int nodes)
        : scratch(plan.scratch /
                  (task + "-" + contestant.full_name() + "-" + std::to_string(::getpid()))),
          world(contestant, nodes, plan.programs, scratch.folder()) {
        world.start_infrastructure();
    }
    Scratch scratch;
    World world;
};

/// Whose infrastructure serves.
struct ReadyStage : Stage {
    ReadyStage(const Contestant& contestant, const Plan& plan, const std::string& task, int nodes)
        : Stage(contestant, plan, task, nodes) {
        world.await_infrastructure();
    }
};

/// A time of steady work: what was sent, used and heard in it.
struct Window {
    Instant begin{};
    Instant end{};
    std::vector<Packet> packets;
    Usage nodes;  // CPU in the window, memory at its end
    Usage infrastructure;

    [[nodiscard]] bool holds(const Sample& sample) const {
        return sample.sent_ns >= ns(begin) && sample.sent_ns < ns(end);
    }
};

Window measure(World& world, Duration time) {
    (void)world.run(settling);
    Window window;
    const Usage nodes = world.node_usage();
    const Usage infrastructure = world.infrastructure_usage();
    window.begin = net::now();
    window.packets = world.run(time);
    window.end = net::now();
    window.nodes = world.node_usage();
    window.nodes.cpu_s -= nodes.cpu_s;
    window.infrastructure = world.infrastructure_usage();
    window.infrastructure.cpu_s -= infrastructure.cpu_s;
    (void)world.run(tail);
    world.stop_nodes();
    return window;
}

void set_delays(Figures& figures, const std::string& what, std::vector<double> delays_ms) {
    const Percentiles delays(std::move(delays_ms));
    figures.set(what + "_p50_ms", delays.at(0.5));
    figures.set(what + "_p99_ms", delays.at(0.99));
    figures.set(what + "_max_ms", delays.max());
}

std::vector<double> delays_ms(const std::vector<Sample>& heard, const Window& window) {
    std::vector<double> delays;
    for (const Sample& sample : heard) {
        if (sample.heard_ns != 0 && window.holds(sample)) {
            delays.push_back(ms(sample.heard_ns - sample.sent_ns));
        }
    }
    return delays;
}

std::size_t published(const std::vector<Sample>& samples, const Window& window) {
    return static_cast<std::size_t>(std::ranges::count_if(samples, [&](const Sample& sample) {
        return sample.heard_ns == 0 && window.holds(sample);
    }));
}

RadioCost radio_cost_of(const Packet& packet) {
    if (packet.kind == Packet::Kind::other) return {};
    return radio_cost(packet.kind == Packet::Kind::tcp ? Transport::tcp : Transport::udp,
                      packet.transport_octets, packet.to == 0);
}

/// What a message costs CPU, network and radio. What brokers say to each other goes by cable, and
/// is counted apart: most of it is there without messages.
void set_costs(Figures& figures, const World& world, const Window& window, double messages) {
    double octets = 0;
    double packets = 0;
    double backbone = 0;
    RadioCost radio;
    for (const Packet& packet : window.packets) {
        if (!world.is_of_a_node(packet.from) && !world.is_of_a_node(packet.to)) {
            if (packet.kind != Packet::Kind::other) backbone += packet.octets;
            continue;
        }
        octets += packet.octets;
        packets += 1;
        radio += radio_cost_of(packet);
    }
    const double seconds = std::chrono::duration<double>(window.end - window.begin).count();
    figures.set("messages", messages);
    figures.set("octets_a_message", octets / messages);
    figures.set("packets_a_message", packets / messages);
    figures.set("frames_a_message", radio.frames / messages);
    figures.set("air_ms_a_message", radio.air_ms / messages);
    figures.set("backbone_octets_a_s", backbone / seconds);
    figures.set("node_cpu_us_a_message", window.nodes.cpu_s * 1e6 / messages);
    figures.set("infrastructure_cpu_us_a_message", window.infrastructure.cpu_s * 1e6 / messages);
    figures.set("infrastructure_cpu_percent", window.infrastructure.cpu_s * 100 / seconds);
    figures.set("infrastructure_mib", window.infrastructure.rss_mib);
}

Figures delay(const Contestant& contestant, const Plan& plan, int rate, unsigned octets) {
    ReadyStage stage(contestant, plan, "delay", 2);
    World& world = stage.world;
    world.start_node(1, {.name = "echo",
                         .publishes = "back",
                         .subscribes = {"there"},
                         .echo = true,
                         .octets = octets});
    world.start_node(0, {.name = "ping",
                         .publishes = "there",
                         .subscribes = {"back"},
                         .rate_per_s = static_cast<double>(rate),
                         .octets = octets});
    world.await_first({1, 0});
    const Duration time = plan.quick ? Duration{1s} : rate < 100 ? Duration{8s} : Duration{4s};
    const Window window = measure(world, time);
    const auto there = world.samples_of(1);
    const auto back = world.samples_of(0);
    Figures figures;
    const auto sent = static_cast<double>(published(back, window));
    auto one_way = delays_ms(there, window);
    auto round = delays_ms(back, window);
    figures.set("lost", 2 * sent - static_cast<double>(one_way.size() + round.size()));
    figures.set(
        "published_percent",
        sent * 100 / rate / std::chrono::duration<double>(window.end - window.begin).count());
    set_costs(figures, world, window, 2 * sent);
    set_delays(figures, "one_way", std::move(one_way));
    set_delays(figures, "round_trip", std::move(round));
    return figures;
}

Figures fan_out(const Contestant& contestant, const Plan& plan, int subscribers) {
    ReadyStage stage(contestant, plan, "fan-out", subscribers + 1);
    World& world = stage.world;
    std::vector<int> numbers(static_cast<std::size_t>(subscribers));
    std::iota(numbers.begin(), numbers.end(), 1);
    for (const int number : numbers) {
        world.start_node(number, {.name = "s" + std::to_string(number), .subscribes = {"all"}});
    }
    world.start_node(0, {.name = "publisher", .publishes = "all", .rate_per_s = 20});
    world.await_first(numbers);
    const Window window = measure(world, plan.quick ? 1s : 3s);
    const auto sent = static_cast<double>(published(world.samples_of(0), window));
    std::vector<double> all;
    std::map<std::uint32_t, double> last_of_message;
    for (const int number : numbers) {
        for (const Sample& sample : world.samples_of(number)) {
            if (sample.heard_ns == 0 || !window.holds(sample)) continue;
            const double delay_ms = ms(sample.heard_ns - sample.sent_ns);
            all.push_back(delay_ms);
            double& last = last_of_message[sample.sequence];
            last = std::max(last, delay_ms);
        }
    }
    std::vector<double> last;
    for (const auto& [sequence, delay_ms] : last_of_message) last.push_back(delay_ms);
    Figures figures;
    figures.set("lost", sent * subscribers - static_cast<double>(all.size()));
    set_costs(figures, world, window, sent);
    set_delays(figures, "one_way", std::move(all));
    set_delays(figures, "last", std::move(last));
    return figures;
}

Figures telemetry(const Contestant& contestant, const Plan& plan, int robots) {
    ReadyStage stage(contestant, plan, "telemetry", robots + 1);
    World& world = stage.world;
    NodeTask observer{.name = "observer"};
    for (int robot = 1; robot <= robots; ++robot) {
        observer.subscribes.push_back("robot" + std::to_string(robot));
    }
    world.start_node(0, observer);
    for (int robot = 1; robot <= robots; ++robot) {
        const std::string name = "robot" + std::to_string(robot);
        world.start_node(robot, {.name = name, .publishes = name, .rate_per_s = 10});
    }
    world.await_first({0});
    (void)world.run(3s);  // until the last robot has been discovered
    const Window window = measure(world, plan.quick ? 1s : 4s);
    double sent = 0;
    for (int robot = 1; robot <= robots; ++robot) {
        sent += static_cast<double>(published(world.samples_of(robot), window));
    }
    auto heard = delays_ms(world.samples_of(0), window);
    Figures figures;
    figures.set("lost", sent - static_cast<double>(heard.size()));
    set_costs(figures, world, window, sent);
    set_delays(figures, "one_way", std::move(heard));
    return figures;
}

Figures start_up(const Contestant& contestant, const Plan& plan) {
    const NodeTask subscriber{.name = "subscriber", .subscribes = {"t"}};
    const NodeTask publisher{.name = "publisher", .publishes = "t", .rate_per_s = 100};
    std::vector<double> cold;
    std::vector<double> warm;
    const auto meet = [&](World& world) {
        const Instant begun = world.start_node(1, subscriber);
        world.start_node(0, publisher);
        world.await_first({1});
        const double took = ms(ns(*world.first_heard(1)) - ns(begun));
        world.stop_nodes();
        return took;
    };
    for (int time = 0; time < (plan.quick ? 1 : 3); ++time) {
        Stage stage(contestant, plan, "start", 2);
        World& world = stage.world;
        cold.push_back(meet(world));
        world.await_infrastructure();
        (void)world.run(1s);
        warm.push_back(meet(world));
    }
    Figures figures;
    figures.set("cold_ms", Percentiles(std::move(cold)).at(0.5));
    figures.set("warm_ms", Percentiles(std::move(warm)).at(0.5));
    return figures;
}

/// Two nodes that know each other and say nothing; of the first.
Figures idle(const Contestant& contestant, const Plan& plan) {
    ReadyStage stage(contestant, plan, "idle", 2);
    World& world = stage.world;
    world.start_node(1, {.name = "other", .publishes = "b", .subscribes = {"a"}});
    (void)world.run(3s);
    world.start_node(0, {.name = "node", .publishes = "a", .subscribes = {"b"}});
    struct Sum {
        double octets = 0;
        double backbone = 0;
        RadioCost radio;
    };
    const auto sum_of = [&world, host = world.host_of_node(0)](const std::vector<Packet>& packets) {
        Sum sum;
        for (const Packet& packet : packets) {
            const bool is_told_to_nodes = packet.to == 0 && world.is_of_a_node(packet.from);
            if (packet.from == host || packet.to == host || is_told_to_nodes) {
                sum.octets += packet.octets;
                sum.radio += radio_cost_of(packet);
            } else if (packet.kind != Packet::Kind::other && !world.is_of_a_node(packet.from) &&
                       !world.is_of_a_node(packet.to)) {
                sum.backbone += packet.octets;
            }
        }
        return sum;
    };
    const Sum joining = sum_of(world.run(5s));
    const Usage before = world.usage_of_node(0);
    const double infrastructure_cpu_s = world.infrastructure_usage().cpu_s;
    const Duration time = plan.quick ? Duration{3s} : Duration{60s};
    const Sum quiet = sum_of(world.run(time));
    const double minutes = std::chrono::duration<double, std::ratio<60>>(time).count();
    const Usage after = world.usage_of_node(0);
    const Usage infrastructure = world.infrastructure_usage();
    Figures figures;
    figures.set("join_octets", joining.octets);
    figures.set("join_air_ms", joining.radio.air_ms);
    figures.set("idle_octets_a_minute", quiet.octets / minutes);
    figures.set("idle_frames_a_minute", quiet.radio.frames / minutes);
    figures.set("idle_air_ms_a_minute", quiet.radio.air_ms / minutes);
    figures.set("backbone_octets_a_minute", quiet.backbone / minutes);
    figures.set("idle_cpu_ms_a_minute", (after.cpu_s - before.cpu_s) * 1e3 / minutes);
    figures.set("node_mib", after.rss_mib);
    figures.set("infrastructure_mib", infrastructure.rss_mib);
    figures.set("infrastructure_cpu_percent",
                (infrastructure.cpu_s - infrastructure_cpu_s) / minutes / 60 * 100);
    return figures;
}

/// The longest time without a message, from `from` on.
double longest_silence_ms(const std::vector<Sample>& heard, std::int64_t from, std::int64_t until) {
    std::vector<std::int64_t> times{from};
    for (const Sample& sample : heard) {
        if (sample.heard_ns > from && sample.heard_ns < until) times.push_back(sample.heard_ns);
    }
    times.push_back(until);
    std::ranges::sort(times);
    std::int64_t longest = 0;
    for (std::size_t i = 1; i < times.size(); ++i) {
        longest = std::max(longest, times[i] - times[i - 1]);
    }
    return ms(longest);
}

double lost(const std::vector<Sample>& publisher, const std::vector<Sample>& subscriber,
            std::int64_t from, std::int64_t until) {
    std::set<std::uint32_t> arrived;
    for (const Sample& sample : subscriber) {
        if (sample.heard_ns != 0) arrived.insert(sample.sequence);
    }
    return static_cast<double>(std::ranges::count_if(publisher, [&](const Sample& sample) {
        return sample.heard_ns == 0 && sample.sent_ns >= from && sample.sent_ns < until &&
               !arrived.contains(sample.sequence);
    }));
}

/// The gaps in what was heard: when the publisher's own samples are not there.
double missing_between(const std::vector<Sample>& heard, std::int64_t from, std::int64_t until) {
    std::set<std::uint32_t> arrived;
    for (const Sample& sample : heard) {
        if (sample.sent_ns >= from && sample.sent_ns < until) arrived.insert(sample.sequence);
    }
    if (arrived.empty()) return 0;
    return static_cast<double>(*arrived.rbegin() - *arrived.begin() + 1 - arrived.size());
}

/// kill -9 of the master, or of the publisher's broker. A newcomer comes a second later. Where
/// there is no other broker, it is started again after three seconds.
Figures death_of_infrastructure(const Contestant& contestant, const Plan& plan) {
    const NodeTask publisher{
        .name = "publisher", .publishes = "t", .rate_per_s = delay_rate_of_deaths};
    ReadyStage stage(contestant, plan, "death", 3);
    World& world = stage.world;
    world.start_node(1, {.name = "subscriber", .subscribes = {"t"}});
    world.start_node(0, publisher);
    world.await_first({1});
    (void)world.run(3s);  // until neighbours' addresses are no news any more
    const Instant killed = net::now();
    world.kill_first_daemon();
    (void)world.run(1s);
    const Instant came = world.start_node(2, {.name = "newcomer", .subscribes = {"t"}});
    (void)world.run(2s);
    const bool is_missed = contestant.brokers == 1;
    if (is_missed) world.start_first_daemon();
    const bool newcomer_hears = world.await_first(2, plan.quick ? 5s : 15s);
    (void)world.run(is_missed ? 12s : 2s);  // until keep-alive has told everybody
    const std::int64_t until = ns(net::now());
    (void)world.run(1s);
    Figures figures;
    if (const auto first = world.first_heard(2)) {
        figures.set("newcomer_ms", ms(ns(*first) - ns(came)));
    }
    bool republished = false;
    if (!newcomer_hears) {
        // The publisher's own samples are lost with it.
        world.start_node(0, publisher);
        republished = world.await_first(2, 15s);
    }
    world.stop_nodes();
    const auto heard = world.samples_of(1);
    figures.set("longest_silence_ms", longest_silence_ms(heard, ns(killed), until));
    figures.set("lost", newcomer_hears ? lost(world.samples_of(0), heard, ns(killed - 100ms), until)
                                       : missing_between(heard, ns(killed - 100ms), until));
    figures.set("infrastructure_restarts", is_missed ? 1 : 0);
    figures.set("node_restarts", newcomer_hears ? 0 : republished ? 1 : 2);
    return figures;
}

/// kill -9 of a subscriber, which is started again after a second; another one listens all the
/// time.
Figures death_of_peer(const Contestant& contestant, const Plan& plan) {
    ReadyStage stage(contestant, plan, "peer", 3);
    World& world = stage.world;
    const NodeTask victim{.name = "victim", .subscribes = {"t"}};
    world.start_node(2, {.name = "bystander", .subscribes = {"t"}});
    world.start_node(1, victim);
    world.start_node(0,
                     {.name = "publisher", .publishes = "t", .rate_per_s = delay_rate_of_deaths});
    world.await_first({1, 2});
    (void)world.run(1s);
    const Instant killed = net::now();
    world.kill_node(1);
    (void)world.run(1s);
    const Instant again = world.start_node(1, victim);
    world.await_first({1});
    (void)world.run(1s);
    const Instant until = net::now();
    (void)world.run(tail);
    const Instant first = *world.first_heard(1);
    world.stop_nodes();
    Figures figures;
    figures.set("again_ms", ms(ns(first) - ns(again)));
    figures.set("lost", lost(world.samples_of(0), world.samples_of(1), ns(killed), ns(until)));
    figures.set("bystander_lost",
                lost(world.samples_of(0), world.samples_of(2), ns(killed), ns(until)));
    figures.set("bystander_silence_ms",
                longest_silence_ms(world.samples_of(2), ns(killed), ns(until)));
    return figures;
}

}  // namespace

const std::vector<std::string>& all_parts() {
    static const std::vector<std::string> parts{"delay", "fan_out", "telemetry",
                                                "start", "idle",    "deaths"};
    return parts;
}

std::vector<int> rates_of(const Plan& plan, int octets) {
    if (plan.quick) return octets == 32 ? std::vector{100} : std::vector<int>{};
    return octets == 32 ? std::vector{10, 100, 1000} : std::vector{100, 1000};
}

std::vector<int> fan_outs_of(const Plan& plan) {
    return plan.quick ? std::vector{3} : std::vector{1, 5, 20, 50};
}

int robots_of(const Plan& plan) {
    return plan.quick ? 3 : 20;
}

std::vector<Task> tasks_of(const Plan& plan) {
    std::vector<Task> all;
    for (const int octets : {32, 512}) {
        for (const int rate : rates_of(plan, octets)) {
            all.push_back({.name = "delay_" + std::to_string(rate) + "_" + std::to_string(octets),
                           .part = "delay",
                           .also_best_effort = true,
                           .work = [=](const Contestant& who, const Plan& how) {
                               return delay(who, how, rate, static_cast<unsigned>(octets));
                           }});
        }
    }
    for (const int subscribers : fan_outs_of(plan)) {
        all.push_back({.name = "fan_out_" + std::to_string(subscribers),
                       .part = "fan_out",
                       .work = [=](const Contestant& who, const Plan& how) {
                           return fan_out(who, how, subscribers);
                       }});
    }
    all.push_back({.name = "telemetry",
                   .part = "telemetry",
                   .also_best_effort = true,
                   .work = [](const Contestant& who, const Plan& how) {
                       return telemetry(who, how, robots_of(how));
                   }});
    all.push_back({.name = "start", .part = "start", .work = start_up});
    all.push_back({.name = "idle", .part = "idle", .all_at_once = true, .work = idle});
    all.push_back({.name = "death_of_infrastructure",
                   .part = "deaths",
                   .also_best_effort = true,
                   .needs_infrastructure = true,
                   .work = death_of_infrastructure});
    all.push_back({.name = "death_of_peer", .part = "deaths", .work = death_of_peer});
    std::erase_if(all, [&](const Task& task) {
        return std::ranges::find(plan.parts, task.part) == plan.parts.end();
    });
    return all;
}

bool takes_part(const Contestant& contestant, const Task& task) {
    return (contestant.reliable || task.also_best_effort) &&
           (contestant.brokers > 0 || !task.needs_infrastructure);
}

}  // namespace romano::bench::ros
