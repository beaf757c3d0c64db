#include "experiments/sweep/cell_run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "experiments/measure/failover.h"
#include "romano/base/random.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::MsgType;

/// What a client must not have to send again when its broker is replaced.
constexpr std::array again_types = {MsgType::connect, MsgType::register_, MsgType::subscribe};

Duration to_duration(std::chrono::duration<double> duration) {
    return std::chrono::duration_cast<Duration>(duration);
}

double in_ms(Duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

double as_number(std::uint64_t count) {
    return static_cast<double>(count);
}

}  // namespace

CellRun::CellRun(const SweepSettings& settings, const Cell& cell,
                 const CellSurroundings& surroundings)
    : settings_(settings), cell_(cell), surroundings_(surroundings) {}

CellRun::~CellRun() = default;

RunRow CellRun::run() {
    RunRow row;
    row.cell = cell_;
    try {
        world_ = surroundings_.make_world(cell_);
        row.started_utc = world_->date();
        begun_ = world_->now();
        start_brokers();
        await_one_view();
        join_robots();
        load();
        drain();
        check_schedule();
    } catch (const RunFailed& failed) {
        row.status = failed.what();
    } catch (const Interrupted&) {
        stop(row);
        throw;
    }
    if (swarm_ && swarm_->account().by_publisher().empty()) swarm_.reset();
    if (swarm_) {
        measure_deliveries(row);
        measure_failover(row);
        measure_brokers(row);
        surroundings_.results.write_samples(cell_, swarm_->account());
        surroundings_.results.write_memory(cell_, memory_);
    }
    stop(row);
    if (world_) row.run_s = in_ms(world_->now() - begun_) / 1e3;
    return row;
}

void CellRun::start_brokers() {
    doing_ = "starting brokers";
    brokers_ = std::make_unique<CellBrokers>(
        settings_, cell_, *world_,
        [this](const std::string& name) { return surroundings_.results.trace_file(cell_, name); });
}

void CellRun::await_one_view() {
    doing_ = "waiting for one view";
    brokers_->watch([this] { on_watch_change(); });
    const auto deadline = begun_ + to_duration(settings_.start_within);
    if (run_until(deadline, [this] { return brokers_->are_whole(); })) return;
    throw RunFailed("the brokers were not in one view within start_within; " +
                    brokers_->what_they_see());
}

void CellRun::join_robots() {
    doing_ = "robots join";
    swarm_ = std::make_unique<Swarm>(
        world_->robots(), world_->surroundings(), brokers_->addresses(),
        Traffic{settings_.pattern, cell_.robots, settings_.group, cell_.qos},
        SwarmOptions{.rate_per_s = cell_.rate_per_s,
                     .payload_octets = cell_.payload_octets,
                     .retry = to_duration(settings_.retry),
                     .seed = cell_.seed * 1'000'003 + cell_.repetition});
    swarm_->join();
    if (settings_.probe_per_s > 0 && cell_.fault != Fault::none) {
        probe_ = std::make_unique<FailoverProbe>(world_->surroundings(), brokers_->addresses(),
                                                 settings_.probe_per_s,
                                                 to_duration(settings_.retry), cell_.seed);
        probe_->join();
    }
    const Instant deadline = world_->now() + to_duration(settings_.start_within);
    const bool done = run_until(deadline, [this] {
        return (swarm_->has_joined() && (!probe_ || probe_->has_joined())) ||
               swarm_->trouble().has_value() || (probe_ && probe_->trouble());
    });
    if (swarm_->trouble()) throw RunFailed("robots could not join: " + *swarm_->trouble());
    if (probe_ && probe_->trouble()) throw RunFailed(*probe_->trouble());
    if (!done) throw RunFailed("not all robots had joined within start_within");
    // Subscriptions reach the other brokers a moment after SUBACK.
    run_for(300ms);
}

void CellRun::load() {
    doing_ = "load";
    brokers_->begin_usage();
    swarm_->start_load();
    if (probe_) probe_->start();
    is_loading_ = true;
    const Instant started = world_->now();
    const Instant end = started + to_duration(settings_.duration);
    if (cell_.fault != Fault::none) {
        run_for(to_duration(settings_.fault_after));
        for (const MsgType type : again_types) sent_before_fault_.push_back(swarm_->sent(type));
        fault_ = std::make_unique<FaultInjection>(
            settings_, cell_, *brokers_,
            std::ofstream(surroundings_.results.trace_file(cell_, "faults")),
            [this](Instant deadline, const auto& done) { return run_until(deadline, done); });
        doing_ = "load, with faults";
        fault_->run(end);
    }
    run_until(end, [] { return false; });
    swarm_->stop_load();
    if (probe_) probe_->stop();
    is_loading_ = false;
    load_time_ = world_->now() - started;
    for (std::size_t i = 0; i < brokers_->size(); ++i) brokers_->end_usage(i);
}

void CellRun::on_watch_change() {
    if (!fault_ || fault_->strikes().empty() || cell_.fault != Fault::kill_leader) return;
    const std::string& dead = (*brokers_)[fault_->strikes().front().broker].name;
    for (auto& broker : *brokers_) {
        if (broker.name == dead || broker.new_leader_at) continue;
        const auto leader = broker.watch->leader();
        if (leader && *leader != dead) broker.new_leader_at = world_->now();
    }
}

void CellRun::drain() {
    doing_ = "last deliveries";
    run_for(250ms);
    run_until(world_->now() + to_duration(settings_.drain),
              [this] { return swarm_->account().is_settled(); });
}

// What a machine could not send in time says nothing about brokers.
void CellRun::check_schedule() const {
    world_->check_measured();
    if (swarm_->worst_lag() <= to_duration(settings_.publish_within)) return;
    throw RunFailed("the publishers fell " +
                    std::to_string(std::lround(in_ms(swarm_->worst_lag()))) +
                    " ms behind their schedule, more than publish_within: this machine was too "
                    "busy");
}

void CellRun::stop(RunRow& row) {
    doing_ = "stopping";
    if (swarm_) swarm_->leave();
    if (probe_) probe_->leave();
    if (world_) world_->finish_moment();
    swarm_.reset();
    probe_.reset();
    try {
        if (brokers_) brokers_->stop_all();
    } catch (const RunFailed& failed) {
        if (row.ok()) row.status = failed.what();
    }
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
    row.out_of_order_qos0 = as_number(by_qos[0].out_of_order);
    row.out_of_order_qos1 = as_number(by_qos[1].out_of_order);
    row.out_of_order_qos2 = as_number(by_qos[2].out_of_order);
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
    if (!fault_ || fault_->strikes().empty()) return;
    const auto& strikes = fault_->strikes();
    std::size_t struck = 0;
    std::vector<double> times;
    std::vector<double> probed;
    for (const Strike& strike : strikes) {
        const auto served = probe_ ? probe_->failover(strike.broker, strike.at) : std::nullopt;
        if (served) probed.push_back(in_ms(*served));
        const auto victims = swarm_->clients_of(strike.broker);
        const auto failovers =
            client_failovers(swarm_->account(), victims, swarm_->seconds_at(strike.at));
        struck += failovers.size();
        for (const ClientFailover& failover : failovers) {
            if (failover.after_ms) times.push_back(*failover.after_ms);
        }
    }
    const Percentiles recovered{std::move(times)};
    row.strikes = as_number(strikes.size());
    row.failover_clients = as_number(struck);
    row.failover_recovered_clients = as_number(recovered.count());
    row.failover_first_ms = recovered.min();
    row.failover_p50_ms = recovered.at(0.5);
    row.failover_last_ms = recovered.max();
    row.failover_probe_ms = Percentiles{std::move(probed)}.max();
    row.connects_after_fault = as_number(swarm_->sent(again_types[0]) - sent_before_fault_[0]);
    row.registers_after_fault = as_number(swarm_->sent(again_types[1]) - sent_before_fault_[1]);
    row.subscribes_after_fault = as_number(swarm_->sent(again_types[2]) - sent_before_fault_[2]);
    if (cell_.fault != Fault::kill_leader) return;
    Duration longest{};
    for (std::size_t i = 0; i < brokers_->size(); ++i) {
        if (i == strikes.front().broker) continue;
        const auto& new_leader_at = (*brokers_)[i].new_leader_at;
        if (!new_leader_at) return;  // there was none until the end
        longest = std::max(longest, *new_leader_at - strikes.front().at);
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
    for (const auto& broker : *brokers_) {
        octets += as_number(broker.octets);
        if (!broker.usage || broker.usage_time <= Duration{}) continue;
        const double used_s = broker.usage->cpu_s - broker.usage_before.cpu_s;
        const double percent = used_s * 1e5 / in_ms(broker.usage_time);
        ++measured;
        cpu_sum += percent;
        cpu_max = std::max(cpu_max, percent);
        rss_sum += broker.usage->rss_peak_mib;
        rss_max = std::max(rss_max, broker.usage->rss_peak_mib);
    }
    row.interbroker_octets_per_s = octets * 1e3 / in_ms(load_time_);
    if (measured == 0) return;
    row.broker_cpu_percent_mean = cpu_sum / measured;
    row.broker_cpu_percent_max = cpu_max;
    row.broker_rss_peak_mib_mean = rss_sum / measured;
    row.broker_rss_peak_mib_max = rss_max;
}

void CellRun::sample_memory(Instant now) {
    if (!is_loading_ || now < next_memory_) return;
    next_memory_ = now + 1s;
    for (std::size_t i = 0; i < brokers_->size(); ++i) {
        const auto& broker = (*brokers_)[i];
        if (broker.is_down) continue;
        const auto usage = world_->usage_of(i);
        if (usage) memory_.push_back({swarm_->seconds_at(now), broker.name, usage->rss_mib});
    }
}

double CellRun::share_over() const {
    // Starting and stopping take about two seconds.
    const double expected_s = settings_.duration.count() + 2;
    return std::min(1.0, in_ms(world_->now() - begun_) / 1e3 / expected_s);
}

bool CellRun::run_until(Instant deadline, const std::function<bool()>& done) {
    return world_->run_until(deadline, done, [this] { look_around(); });
}

void CellRun::look_around() {
    const Instant now = world_->now();
    if (now - checked_ <= 50ms) return;
    checked_ = now;
    if (brokers_) brokers_->check();
    sample_memory(now);
    if (surroundings_.is_interrupted()) throw Interrupted{};
    surroundings_.on_progress(share_over(), doing_);
}

void CellRun::run_for(Duration duration) {
    run_until(world_->now() + duration, [] { return false; });
}

}  // namespace romano::experiments
