#include "bench/failover/bench.h"

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <stdexcept>
#include <utility>

#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "experiments/load/load_run.h"
#include "experiments/load/mqttsn_clients.h"
#include "experiments/watch/metrics_fetch.h"
#include "experiments/watch/metrics_page.h"

namespace romano::bench {
namespace {

using namespace std::chrono_literals;
using mqttsn::MsgType;

constexpr Duration publish_every = 1ms;
constexpr Duration together_within = 20s;
constexpr Duration message_within = 10s;
// The next fault comes at any phase of the brokers' beacons.
constexpr Duration rest_least = 50ms;
constexpr Duration rest_most = 150ms;
// Full load: so many publishers and subscribers a broker, with so many messages on their way.
constexpr std::size_t clients_a_broker = 20;
constexpr std::uint32_t messages_a_publisher = 4;

/// Their clients are the robots, one a broker, and behind them those of the full load.
std::optional<Fleet> fleet_for(const Options& options, const std::filesystem::path& folder) {
    if (options.packets == Endpoint::Packets::plain) return std::nullopt;
    std::vector<std::string> brokers;
    for (std::uint32_t n = 1; n <= options.brokers; ++n) {
        brokers.push_back("b" + std::to_string(n));
    }
    const auto loaders = static_cast<std::uint32_t>(2 * clients_a_broker * options.brokers);
    return Fleet(folder, brokers, options.brokers + (options.watch_s > 0 ? loaders : 0));
}

std::uint64_t leases_lost(const Cluster& cluster, std::size_t broker) {
    const experiments::MetricsPage page{experiments::fetch_metrics(*cluster.metrics(broker), 1s)};
    return static_cast<std::uint64_t>(page.value("romano_cluster_leases_lost_total"));
}

Options with_metrics(Options options) {
    if (options.watch_s > 0 && options.metrics_port == 0) options.metrics_port = 9884;
    return options;
}

}  // namespace

Bench::Bench(boost::asio::io_context& io, const Options& options,
             const std::filesystem::path& traces)
    : io_(io),
      options_(with_metrics(options)),
      fleet_(fleet_for(options, options.output / "fleet")),
      cluster_(options_, traces, fleet_ ? &*fleet_ : nullptr),
      random_(options.seed) {}

Bench::~Bench() = default;

std::shared_ptr<keys::ClientPackets> Bench::key_of(std::uint32_t robot) const {
    if (!fleet_) return nullptr;
    const bool speaks_dtls = options_.packets == Endpoint::Packets::dtls;
    return std::make_shared<keys::ClientPackets>(
        fleet_->key_file(robot), std::string{},
        speaks_dtls ? keys::Speech::dtls : keys::Speech::packets);
}

void Bench::start() {
    await_whole();
    for (std::size_t i = 0; i < cluster_.size(); ++i) {
        const auto number = static_cast<std::uint32_t>(i);
        robots_.push_back(
            std::make_unique<Robot>(io_, number, cluster_.address(i), options_.qos, key_of(number),
                                    [this, i](Instant at, const experiments::Stamp& stamp) {
                                        if (!awaited_ || awaited_->robot != i || awaited_->arrived)
                                            return;
                                        if (stamp.sent_at >= awaited_->since)
                                            awaited_->arrived = at;
                                    }));
    }
    const auto are_ready = [this] {
        return std::ranges::all_of(robots_, [](const auto& robot) { return robot->is_ready(); });
    };
    if (!run_until(net::now() + together_within, are_ready)) {
        throw std::runtime_error("the clients could not connect to the brokers");
    }
    run_for(300ms);
}

void Bench::await_whole() {
    const auto is_whole = [this] {
        cluster_.look();
        return cluster_.is_whole();
    };
    if (!run_until(net::now() + together_within, is_whole)) {
        throw std::runtime_error(
            "the brokers were not in one view of all, each at its own "
            "address, within 20 s; their traces tell why");
    }
}

std::size_t Bench::choose_victim() {
    const auto leader = cluster_.leader();
    if (!leader) throw std::runtime_error("nobody leads");
    if (options_.victim == Victim::leader) return *leader;
    const auto others = static_cast<std::uint32_t>(cluster_.size() - 1);
    return (*leader + 1 + random_.below(others)) % cluster_.size();
}

void Bench::strike(std::size_t victim) {
    options_.fault == Fault::crash ? cluster_.kill(victim) : cluster_.pause(victim);
}

Trial Bench::run(std::uint32_t number) {
    run_for(random_.between(rest_least, rest_most));
    cluster_.look();
    const std::size_t victim = choose_victim();
    Robot& witness = *robots_[victim];
    const auto others = static_cast<std::uint32_t>(cluster_.size() - 1);
    publisher_ = (victim + 1 + random_.below(others)) % cluster_.size();
    run_for(random_.between(10ms, 20ms));  // the load runs

    Trial trial{.number = number,
                .victim = cluster_.name(victim),
                .led = cluster_.leader() == victim,
                .heir = {}};
    constexpr std::array again = {MsgType::connect, MsgType::register_, MsgType::subscribe};
    const auto sent = [&] {
        return std::array{witness.sent(again[0]), witness.sent(again[1]), witness.sent(again[2])};
    };
    const auto sent_before = sent();
    const std::uint64_t handshakes_before = witness.handshakes();
    const Instant fault = net::now();
    strike(victim);
    const auto arrival = await_message(victim, fault, message_within);
    cluster_.look();
    if (arrival) {
        trial.total_ms = ms_between(fault, *arrival);
        read_parts(cluster_, victim, fault, *arrival, trial);
    }

    const Instant revival = net::now();
    cluster_.revive(victim);
    await_whole();
    if (const auto heard = await_message(victim, net::now(), message_within)) {
        trial.return_ms = ms_between(revival, *heard);
    }
    publisher_.reset();
    const auto sent_after = sent();
    trial.connects = sent_after[0] - sent_before[0];
    trial.registers = sent_after[1] - sent_before[1];
    trial.subscribes = sent_after[2] - sent_before[2];
    trial.handshakes = witness.handshakes() - handshakes_before;
    return trial;
}

Watched Bench::watch(Duration duration, const std::function<bool()>& is_over) {
    const Instant begun = net::now();
    const auto count = [&](std::string_view beginning) {
        std::uint64_t lines = 0;
        for (std::size_t i = 0; i < cluster_.size(); ++i) {
            lines += static_cast<std::uint64_t>(
                std::ranges::count_if(cluster_.trace(i).lines(), [&](const TraceLine& line) {
                    return line.at && *line.at >= begun && line.text.starts_with(beginning);
                }));
        }
        return lines;
    };
    const auto each = static_cast<std::uint32_t>(clients_a_broker * cluster_.size());
    const experiments::LoadPlan plan{.publishers = each,
                                     .subscribers = each,
                                     .topics = each,
                                     .qos = static_cast<mqttsn::Qos>(options_.qos),
                                     .in_flight = messages_a_publisher * each,
                                     .warm_up = {},
                                     .duration = duration};
    experiments::MqttsnOptions clients{.brokers = {},
                                       .sockets = experiments::SocketUse::shared,
                                       .timing = {.t_retry = 500ms, .t_wait = 1s, .n_retry = 60}};
    if (fleet_) {
        clients.keyed = [this](std::uint32_t client, keys::ClientSpeech::Put put) {
            return fleet_->client(options_.brokers + client, options_.packets, std::move(put));
        };
    }
    for (std::size_t i = 0; i < cluster_.size(); ++i) {
        clients.brokers.push_back(*net::parse_endpoint(cluster_.address_text(i)));
    }
    experiments::MqttsnClients loaders(plan, clients);
    std::vector<std::uint64_t> lost_before;
    for (std::size_t i = 0; i < cluster_.size(); ++i)
        lost_before.push_back(leases_lost(cluster_, i));
    std::optional<std::size_t> victim;
    bool is_back = false;
    const double share_away = options_.away_s / std::chrono::duration<double>(duration).count();
    const auto strike_in_the_middle = [&](double share) {
        if (!victim && share > 0.5 - share_away / 2) {
            cluster_.look();
            victim = choose_victim();
            strike(*victim);
        } else if (victim && !is_back && share > 0.5 + share_away / 2) {
            cluster_.revive(*victim);
            is_back = true;
        }
    };
    experiments::LoadRun load(plan, loaders,
                              {.on_progress =
                                   [&](const std::string& phase, double share) {
                                       io_.restart();
                                       io_.poll();  // our robots stay connected
                                       if (options_.away_s == 0 || phase != "measuring") return;
                                       strike_in_the_middle(share);
                                   },
                               .on_measuring = {},
                               .on_measured = {},
                               .is_stopped = is_over});
    const MachineStalls stalls;
    const experiments::LoadFigures figures = load.run();
    const auto machine_stalls = stalls.seen();
    cluster_.look();
    std::uint64_t lost_since = 0;
    for (std::size_t i = 0; i < cluster_.size(); ++i) {
        if (i != victim) lost_since += leases_lost(cluster_, i) - lost_before[i];
    }
    return {.seconds = figures.measured_s,
            .messages = figures.delivered,
            .lost = figures.lost(),
            .suspicions = count("lost "),
            .leases_lost = lost_since,
            .take_overs = count("adopts ") - (victim ? 1 : 0),  // the victim's, rightly
            .away_s = options_.away_s,
            .machine_stalls = machine_stalls};
}

std::optional<Instant> Bench::await_message(std::size_t robot, Instant since, Duration patience) {
    awaited_ = Awaited{robot, since, std::nullopt};
    run_until(since + patience, [this] { return awaited_->arrived.has_value(); });
    return std::exchange(awaited_, std::nullopt)->arrived;
}

void Bench::publish_on() {
    const Instant now = net::now();
    if (!publisher_ || now < next_publish_) return;
    next_publish_ = std::max(next_publish_ + publish_every, now);
    robots_[*publisher_]->publish();
}

bool Bench::run_until(Instant deadline, const std::function<bool()>& done) {
    const auto stays = boost::asio::make_work_guard(io_);
    io_.restart();
    while (!done()) {
        const Instant now = net::now();
        if (now >= deadline) return false;
        publish_on();
        if (std::ranges::any_of(robots_, [](const auto& robot) { return robot->has_failed(); })) {
            throw std::runtime_error("a client was told that it is not connected any more");
        }
        const Instant next = publisher_ ? std::min(deadline, next_publish_) : deadline;
        io_.run_one_until(net::to_steady_clock(std::min(next, now + 1ms)));
    }
    return true;
}

void Bench::run_for(Duration duration) {
    run_until(net::now() + duration, [] { return false; });
}

}  // namespace romano::bench
