#include "experiments/sweep/cell_run.h"

#include <algorithm>
#include <array>
#include <boost/asio/executor_work_guard.hpp>
#include <ctime>

#include "broker/net/clock.h"
#include "experiments/measure/failover.h"
#include "romano/base/random.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::MsgType;

/// What a client must not have to send again when its broker is replaced.
constexpr std::array again_types = {MsgType::connect, MsgType::register_, MsgType::subscribe};

/// How long brokers get to end by themselves.
constexpr auto stop_patience = 2s;

struct RunFailed : std::runtime_error {
    using std::runtime_error::runtime_error;
};

Duration to_duration(std::chrono::duration<double> duration) {
    return std::chrono::duration_cast<Duration>(duration);
}

double in_ms(Duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    ::gmtime_r(&now, &utc);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
    return text.data();
}

double as_number(std::uint64_t count) {
    return static_cast<double>(count);
}

}  // namespace

struct CellRun::Broker {
    std::string name;
    BrokerAddress address;
    std::unique_ptr<BrokerProcess> process;
    std::unique_ptr<BrokerWatch> watch;  // with this broker's eyes

    /// What it used within the load, or until it was killed.
    ProcessUsage usage_before;
    std::optional<ProcessUsage> usage;
    Instant usage_from{};
    Duration usage_time{};
    std::uint64_t octets_before = 0;
    std::uint64_t octets = 0;

    /// The broker's own count, as fresh as its last word.
    [[nodiscard]] std::uint64_t octets_sent() const {
        const auto own = watch->brokers().find(name);
        return own == watch->brokers().end() ? 0 : own->second.status.transport_octets_sent;
    }

    /// After the leader's death: when this broker was seen to follow a new one.
    std::optional<Instant> new_leader_at;
};

CellRun::CellRun(const SweepSettings& settings, const Cell& cell,
                 const CellSurroundings& surroundings)
    : settings_(settings), cell_(cell), surroundings_(surroundings) {}

CellRun::~CellRun() = default;

RunRow CellRun::run() {
    RunRow row;
    row.cell = cell_;
    row.started_utc = utc_now();
    begun_ = net::now();
    try {
        start_brokers();
        await_one_view();
        join_robots();
        load();
        drain();
    } catch (const RunFailed& failed) {
        row.status = failed.what();
    } catch (const Interrupted&) {
        stop();
        throw;
    }
    if (swarm_ && swarm_->account().by_publisher().empty()) swarm_.reset();
    if (swarm_) {
        measure_deliveries(row);
        measure_failover(row);
        measure_brokers(row);
        surroundings_.results.write_samples(cell_, swarm_->account());
    }
    stop();
    row.run_s = in_ms(net::now() - begun_) / 1e3;
    return row;
}

void CellRun::start_brokers() {
    doing_ = "starting brokers";
    // Another network for each cell: nothing of an earlier one can answer.
    const std::string network =
        settings_.network + "." + std::to_string(cell_.number % 250 + 1) + ".";
    const std::uint32_t domain = settings_.domain_base + (cell_.number - 1) % domains_in_turn;
    for (std::uint32_t i = 1; i <= cell_.brokers; ++i) {
        auto broker = std::make_unique<Broker>();
        broker->name = "b" + std::to_string(i);
        const std::string address = network + std::to_string(i);
        broker->address = {boost::asio::ip::make_address(address), settings_.port};
        std::vector<std::string> arguments = {"--name", broker->name, "--listen",
                                              address + ":" + std::to_string(settings_.port)};
        if (cell_.brokers > 1) {
            const std::vector<std::string> cluster = {
                "--domain",    std::to_string(domain), "--interface",  "lo",     "--elector",
                cell_.elector, "--detector",           cell_.detector, "--acks", cell_.acks};
            arguments.insert(arguments.end(), cluster.begin(), cluster.end());
            if (cell_.elector == "raft") {
                arguments.emplace_back("--voters");
                for (std::uint32_t v = 1; v <= cell_.brokers; ++v) {
                    arguments.push_back("b" + std::to_string(v));
                }
            }
        }
        try {
            broker->process = std::make_unique<BrokerProcess>(
                broker->name, surroundings_.broker_program, arguments,
                surroundings_.results.trace_file(cell_, broker->name));
        } catch (const std::runtime_error& error) {
            throw RunFailed(error.what());
        }
        brokers_.push_back(std::move(broker));
    }
}

void CellRun::await_one_view() {
    doing_ = "waiting for one view";
    // A broker that does not listen yet is asked again soon, as long as we are willing to wait.
    client::Timing timing;
    timing.t_retry = 100ms;
    timing.n_retry = static_cast<int>(settings_.start_within / 100ms) + 300;
    for (const auto& broker : brokers_) {
        broker->watch = std::make_unique<BrokerWatch>(surroundings_.io, broker->address,
                                                      "watch-" + broker->name, timing,
                                                      [this] { on_watch_change(); });
    }
    const auto in_one_view = [this] {
        const auto leader = brokers_.front()->watch->leader();
        return leader && std::ranges::all_of(brokers_, [&](const auto& broker) {
                   return broker->watch->alive() == brokers_.size() &&
                          broker->watch->members_in_view_of(broker->name) == brokers_.size() &&
                          broker->watch->leader() == leader;
               });
    };
    if (run_until(begun_ + to_duration(settings_.start_within), in_one_view)) return;
    std::string sentence = "the brokers were not in one view within start_within; seen alive:";
    for (const auto& broker : brokers_) {
        sentence += " " + broker->name + " sees " + std::to_string(broker->watch->alive()) +
                    " in a view of " +
                    std::to_string(broker->watch->members_in_view_of(broker->name)) + " led by " +
                    broker->watch->leader().value_or("nobody") + ";";
    }
    sentence.pop_back();
    throw RunFailed(sentence);
}

void CellRun::join_robots() {
    doing_ = "robots join";
    std::vector<BrokerAddress> addresses;
    for (const auto& broker : brokers_) addresses.push_back(broker->address);
    swarm_ = std::make_unique<Swarm>(
        surroundings_.io, addresses,
        Traffic{settings_.pattern, cell_.robots, settings_.group, cell_.qos},
        SwarmOptions{.rate_per_s = cell_.rate_per_s,
                     .payload_octets = cell_.payload_octets,
                     .retry = to_duration(settings_.retry),
                     .seed = cell_.seed * 1'000'003 + cell_.repetition});
    swarm_->join();
    const Instant deadline = net::now() + to_duration(settings_.start_within);
    const bool done = run_until(
        deadline, [this] { return swarm_->has_joined() || swarm_->trouble().has_value(); });
    if (swarm_->trouble()) throw RunFailed("robots could not join: " + *swarm_->trouble());
    if (!done) throw RunFailed("not all robots had joined within start_within");
    // Subscriptions reach the other brokers a moment after SUBACK.
    run_for(300ms);
}

void CellRun::load() {
    doing_ = "load";
    begin_usage();
    swarm_->start_load();
    const Instant started = net::now();
    const Instant end = started + to_duration(settings_.duration);
    if (cell_.fault != Fault::none) {
        run_until(started + to_duration(settings_.fault_after), [] { return false; });
        inject_fault();
        doing_ = "load, after the fault";
        if (cell_.fault == Fault::pause) {
            run_until(std::min(end, fault_->at + to_duration(settings_.pause)),
                      [] { return false; });
            brokers_[fault_->broker]->process->resume();
        }
    }
    run_until(end, [] { return false; });
    swarm_->stop_load();
    for (const auto& broker : brokers_) end_usage(*broker);
}

void CellRun::inject_fault() {
    FaultRecord fault;
    fault.broker = choose_victim();
    Broker& victim = *brokers_[fault.broker];
    for (const MsgType type : again_types) fault.sent_before.push_back(swarm_->sent(type));
    if (cell_.fault == Fault::pause) {
        fault.at = net::now();
        fault.at_s = swarm_->seconds_since_start();
        victim.process->pause();
    } else {
        end_usage(victim);
        fault.at = net::now();
        fault.at_s = swarm_->seconds_since_start();
        victim.process->kill();
    }
    fault_ = std::move(fault);
}

std::size_t CellRun::choose_victim() const {
    const auto leader = brokers_.front()->watch->leader();
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        const bool leads = brokers_[i]->name == leader;
        if (leads == (cell_.fault == Fault::kill_leader)) candidates.push_back(i);
    }
    if (candidates.empty()) throw RunFailed("nobody led when the fault was due");
    Random random{cell_.seed * 1'000'003 + cell_.repetition + 2};
    return candidates[random.below(static_cast<std::uint32_t>(candidates.size()))];
}

void CellRun::on_watch_change() {
    if (!fault_ || cell_.fault != Fault::kill_leader) return;
    const std::string& dead = brokers_[fault_->broker]->name;
    for (const auto& broker : brokers_) {
        if (broker->name == dead || broker->new_leader_at) continue;
        const auto leader = broker->watch->leader();
        if (leader && *leader != dead) broker->new_leader_at = net::now();
    }
}

void CellRun::drain() {
    doing_ = "last deliveries";
    run_for(250ms);
    run_until(net::now() + to_duration(settings_.drain),
              [this] { return swarm_->account().is_settled(); });
}

void CellRun::stop() {
    doing_ = "stopping";
    if (swarm_) swarm_->leave();
    // Handlers that are ready refer to robots and watches: they run before those are gone.
    surroundings_.io.restart();
    surroundings_.io.poll();
    swarm_.reset();
    for (const auto& broker : brokers_) broker->watch.reset();
    // All are asked before anybody is waited for.
    for (const auto& broker : brokers_) {
        if (broker->process) broker->process->ask_to_stop();
    }
    for (const auto& broker : brokers_) {
        if (broker->process) broker->process->stop(stop_patience);
    }
    brokers_.clear();
}

void CellRun::measure_deliveries(RunRow& row) const {
    const DeliveryAccount& account = swarm_->account();
    const auto by_qos = account.tally_by_qos();
    DeliveryTally all;
    for (const DeliveryTally& tally : by_qos) all += tally;
    row.published = as_number(all.published);
    row.acknowledged = as_number(all.acknowledged);
    row.unacknowledged = as_number(by_qos[1].published + by_qos[2].published - all.acknowledged);
    row.expected = as_number(all.expected);
    row.delivered = as_number(all.delivered);
    row.delivery_ratio = all.ratio();
    row.delivery_ratio_qos0 = by_qos[0].ratio();
    row.delivery_ratio_qos1 = by_qos[1].ratio();
    row.delivery_ratio_qos2 = by_qos[2].ratio();
    row.acknowledged_but_lost_qos1 = as_number(by_qos[1].acknowledged_but_lost);
    row.acknowledged_but_lost_qos2 = as_number(by_qos[2].acknowledged_but_lost);
    row.duplicates_qos0 = as_number(by_qos[0].duplicates);
    row.duplicates_qos1 = as_number(by_qos[1].duplicates);
    row.duplicates_qos2 = as_number(by_qos[2].duplicates);
    row.stray_messages = as_number(account.strays());
    row.publish_refused = as_number(swarm_->refused());
    row.publish_lag_max_ms = in_ms(swarm_->worst_lag());
    const Percentiles delays = account.delays_ms();
    row.delay_min_ms = delays.min();
    row.delay_p50_ms = delays.at(0.5);
    row.delay_p99_ms = delays.at(0.99);
    row.delay_max_ms = delays.max();
    const Percentiles fan_out = account.fan_out_delays_ms();
    row.fan_out_p50_ms = fan_out.at(0.5);
    row.fan_out_p99_ms = fan_out.at(0.99);
    row.fan_out_max_ms = fan_out.max();
}

void CellRun::measure_failover(RunRow& row) const {
    if (!fault_) return;
    const auto victims = swarm_->clients_of(fault_->broker);
    std::vector<double> times;
    for (const ClientFailover& failover :
         client_failovers(swarm_->account(), victims, fault_->at_s)) {
        if (failover.after_ms) times.push_back(*failover.after_ms);
    }
    const Percentiles failovers{std::move(times)};
    row.failover_clients = as_number(victims.size());
    row.failover_recovered_clients = as_number(failovers.count());
    row.failover_first_ms = failovers.min();
    row.failover_p50_ms = failovers.at(0.5);
    row.failover_last_ms = failovers.max();
    row.connects_after_fault = as_number(swarm_->sent(again_types[0]) - fault_->sent_before[0]);
    row.registers_after_fault = as_number(swarm_->sent(again_types[1]) - fault_->sent_before[1]);
    row.subscribes_after_fault = as_number(swarm_->sent(again_types[2]) - fault_->sent_before[2]);
    if (cell_.fault != Fault::kill_leader) return;
    Duration longest{};
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        if (i == fault_->broker) continue;
        if (!brokers_[i]->new_leader_at) return;  // there was none until the end
        longest = std::max(longest, *brokers_[i]->new_leader_at - fault_->at);
    }
    row.without_leader_ms = in_ms(longest);
}

void CellRun::measure_brokers(RunRow& row) const {
    double octets = 0;
    double cpu_sum = 0;
    double cpu_max = 0;
    double rss_sum = 0;
    double rss_max = 0;
    double measured = 0;
    for (const auto& broker : brokers_) {
        octets += as_number(broker->octets);
        if (!broker->usage || broker->usage_time <= Duration{}) continue;
        const double used_s = broker->usage->cpu_s - broker->usage_before.cpu_s;
        const double percent = used_s * 1e5 / in_ms(broker->usage_time);
        ++measured;
        cpu_sum += percent;
        cpu_max = std::max(cpu_max, percent);
        rss_sum += broker->usage->rss_peak_mib;
        rss_max = std::max(rss_max, broker->usage->rss_peak_mib);
    }
    row.interbroker_octets_per_s = octets / settings_.duration.count();
    if (measured == 0) return;
    row.broker_cpu_percent_mean = cpu_sum / measured;
    row.broker_cpu_percent_max = cpu_max;
    row.broker_rss_peak_mib_mean = rss_sum / measured;
    row.broker_rss_peak_mib_max = rss_max;
}

void CellRun::begin_usage() {
    for (const auto& broker : brokers_) {
        broker->usage_before = usage_of(broker->process->pid()).value_or(ProcessUsage{});
        broker->usage_from = net::now();
        broker->octets_before = broker->octets_sent();
    }
}

void CellRun::end_usage(Broker& broker) {
    if (broker.usage) return;  // killed before
    broker.usage = usage_of(broker.process->pid());
    broker.usage_time = net::now() - broker.usage_from;
    broker.octets = broker.octets_sent() - broker.octets_before;
}

void CellRun::check_brokers() {
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        const bool killed = fault_ && fault_->broker == i && cell_.fault != Fault::pause;
        BrokerProcess& process = *brokers_[i]->process;
        if (!killed && process.has_ended()) {
            throw RunFailed("broker " + process.name() + " ended unexpectedly, " +
                            process.how_it_ended());
        }
    }
}

double CellRun::share_over() const {
    // Starting and stopping take about two seconds.
    const double expected_s = settings_.duration.count() + 2;
    return std::min(1.0, in_ms(net::now() - begun_) / 1e3 / expected_s);
}

bool CellRun::run_until(Instant deadline, const std::function<bool()>& done) {
    const auto end = net::to_steady_clock(deadline);
    auto& io = surroundings_.io;
    const auto stays = boost::asio::make_work_guard(io);
    io.restart();
    while (!done()) {
        const Instant now = net::now();
        if (now >= deadline) return false;
        if (now - checked_ > 50ms) {
            checked_ = now;
            check_brokers();
            if (surroundings_.is_interrupted()) throw Interrupted{};
            surroundings_.on_progress(share_over(), doing_);
        }
        io.run_one_until(std::min(end, net::to_steady_clock(now + 20ms)));
    }
    return true;
}

void CellRun::run_for(Duration duration) {
    run_until(net::now() + duration, [] { return false; });
}

}  // namespace romano::experiments
