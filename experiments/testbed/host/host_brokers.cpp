#include "experiments/testbed/host/host_brokers.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>
#include <utility>

#include "broker/net/machine_address.h"
#include "experiments/testbed/host/service_endpoint.h"
#include "experiments/watch/metrics_fetch.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr auto stop_patience = 2s;
constexpr auto lease_time = 5s;
constexpr auto metrics_patience = 500ms;
constexpr std::streamoff most_of_a_trace = 4 << 20;

std::string end_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary | std::ios::ate);
    const std::streamoff size = stream.tellg();
    stream.seekg(std::max<std::streamoff>(0, size - most_of_a_trace));
    return {std::istreambuf_iterator<char>(stream), {}};
}

void hold_address(const std::string& address) {
    const auto endpoint = endpoint_at(address);
    if (!endpoint) return;
    const auto interface = net::interface_towards(*endpoint);
    if (interface) (void)net::add_address(*endpoint, *interface, lease_time);
}

}  // namespace

void forget_addresses(const std::vector<std::string>& addresses) {
    for (const std::string& address : addresses) {
        const auto endpoint = endpoint_at(address);
        if (!endpoint || !net::is_leased(*endpoint)) continue;  // never what the machine has itself
        const auto interface = net::interface_towards(*endpoint);
        if (interface) (void)net::remove_address(*endpoint, *interface);
    }
}

HostBrokers::HostBrokers(std::filesystem::path programs, std::filesystem::path traces,
                         std::vector<std::string> addresses)
    : programs_(std::move(programs)), traces_(std::move(traces)), addresses_(std::move(addresses)) {
    remove_addresses();
}

HostBrokers::~HostBrokers() {
    stop_all();
}

void HostBrokers::start(const ProgramOrder& order) {
    Life life{.order = order, .process = nullptr, .trouble = {}};
    if (!order.lease.empty()) hold_address(order.lease);
    // The names come from elsewhere: they stay in their folders.
    const auto trace = std::filesystem::path{order.trace}.filename();
    const auto program = std::filesystem::path{order.program}.filename();
    try {
        life.process = std::make_unique<BrokerProcess>(order.name, programs_ / program,
                                                       order.arguments, traces_ / trace);
    } catch (const std::runtime_error& error) {
        life.trouble = error.what();
    }
    trace_names_.push_back(trace);
    lives_.insert_or_assign(order.number, std::move(life));
}

BrokerProcess* HostBrokers::running(std::uint32_t number) {
    const auto found = lives_.find(number);
    return found == lives_.end() ? nullptr : found->second.process.get();
}

void HostBrokers::kill(std::uint32_t number) {
    if (auto* process = running(number)) process->kill();
}

void HostBrokers::pause(std::uint32_t number) {
    if (auto* process = running(number)) process->pause();
}

void HostBrokers::resume(std::uint32_t number) {
    if (auto* process = running(number)) process->resume();
}

void HostBrokers::ask_to_stop(std::uint32_t number) {
    if (auto* process = running(number)) process->ask_to_stop();
}

void HostBrokers::stop_all() {
    for (auto& [number, life] : lives_) {
        if (life.process) life.process->ask_to_stop();
    }
    const auto deadline = std::chrono::steady_clock::now() + stop_patience;
    const auto has_ended = [](auto& each) {
        return !each.second.process || each.second.process->has_ended();
    };
    while (!std::ranges::all_of(lives_, has_ended) && std::chrono::steady_clock::now() < deadline) {
        std::this_thread::sleep_for(2ms);
    }
    for (auto& [number, life] : lives_) {
        if (life.process) life.process->kill();
    }
    remove_addresses();
}

std::vector<EndedLife> HostBrokers::look() {
    std::vector<EndedLife> ended;
    for (auto& [number, life] : lives_) {
        if (life.is_told || (life.process && !life.process->has_ended())) continue;
        life.is_told = true;
        ended.push_back(
            {number, life.order.life, life.process ? life.process->how_it_ended() : life.trouble});
    }
    return ended;
}

std::vector<UsedByLife> HostBrokers::usage() const {
    std::vector<UsedByLife> all;
    for (const auto& [number, life] : lives_) {
        if (!life.process) continue;
        const auto used = usage_of(life.process->pid());
        if (used) all.push_back({number, life.order.life, *used});
    }
    return all;
}

std::map<std::string, std::string> HostBrokers::traces() const {
    std::map<std::string, std::string> all;
    for (const std::string& name : trace_names_) all[name] = end_of(traces_ / name);
    return all;
}

std::map<std::string, std::string> HostBrokers::metrics() const {
    std::map<std::string, std::string> all;
    for (const auto& [number, life] : lives_) {
        if (!life.process || life.process->has_ended() || life.order.metrics_port == 0) continue;
        try {
            all[life.order.trace] = fetch_metrics(
                {.host = "127.0.0.1", .port = std::to_string(life.order.metrics_port)},
                metrics_patience);
        } catch (const std::runtime_error&) {
            // It is about to be stopped: what it cannot say now, nobody will know.
        }
    }
    return all;
}

void HostBrokers::renew_leases() {
    for (auto& [number, life] : lives_) {
        if (life.order.lease.empty() || !life.process || life.process->has_ended()) continue;
        hold_address(life.order.lease);
    }
}

void HostBrokers::remove_addresses() const {
    forget_addresses(addresses_);
}

}  // namespace romano::experiments
