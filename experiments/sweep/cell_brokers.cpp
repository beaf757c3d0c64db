#include "experiments/sweep/cell_brokers.h"

#include <algorithm>
#include <chrono>
#include <sstream>
#include <utility>

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

/// "127.50.2.1:11883".
std::string text_of(const BrokerAddress& address) {
    std::ostringstream text;
    text << address;
    return text.str();
}

}  // namespace

const BrokerStatus* CellBrokers::Broker::own_status() const {
    if (watch == nullptr) return nullptr;
    const auto own = watch->brokers().find(name);
    return own == watch->brokers().end() ? nullptr : &own->second.status;
}

std::uint64_t CellBrokers::Broker::octets_sent() const {
    const BrokerStatus* own = own_status();
    return own == nullptr ? 0 : own->transport_octets_sent;
}

bool CellBrokers::Broker::is_at_home_in_view_of(std::size_t members) const {
    const BrokerStatus* own = own_status();
    if (is_down || own == nullptr || own->incarnation == former_incarnation) return false;
    return own->view_members.size() == members && watch->alive() == members &&
           std::ranges::count(own->addresses, home) > 0;
}

CellBrokers::CellBrokers(const SweepSettings& settings, const Cell& cell, CellWorld& world,
                         TraceOf trace_of)
    : settings_(settings), cell_(cell), world_(world), trace_of_(std::move(trace_of)) {
    brokers_.resize(cell.brokers);
    for (std::size_t i = 0; i < size(); ++i) {
        brokers_[i].name = name_of(i);
        brokers_[i].address = world.address_of(i);
        brokers_[i].home =
            (cell.clients == "plain" ? "" : cell.clients + "://") + text_of(brokers_[i].address);
    }
    for (std::size_t i = 0; i < size(); ++i) start(i);  // each may have to name all (voters)
}

std::string CellBrokers::name_of(std::size_t number) {
    return "b" + std::to_string(number + 1);
}

std::string CellBrokers::watch_of(std::size_t number) {
    return "watch-" + name_of(number);
}

std::vector<std::string> CellBrokers::arguments_of(std::size_t number) const {
    std::vector<std::string> arguments = {"--name", brokers_[number].name, "--listen",
                                          brokers_[number].home, "--allow-plain"};
    arguments.insert(arguments.end(), settings_.broker_options.begin(),
                     settings_.broker_options.end());
    if (cell_.brokers == 1) return arguments;
    arguments.insert(arguments.end(), {"--elector", cell_.elector, "--detector", cell_.detector,
                                       "--acks", cell_.acks});
    if (cell_.elector == "raft") {
        arguments.emplace_back("--voters");
        for (const Broker& voter : brokers_) arguments.push_back(voter.name);
    }
    return arguments;
}

std::vector<BrokerAddress> CellBrokers::addresses() const {
    std::vector<BrokerAddress> addresses;
    for (const Broker& broker : brokers_) addresses.push_back(broker.address);
    return addresses;
}

void CellBrokers::watch(const std::function<void()>& on_change) {
    // A broker that does not listen yet is asked again soon, as long as we are willing to wait.
    client::Timing timing;
    timing.t_retry = 100ms;
    timing.n_retry = static_cast<int>(settings_.start_within / 100ms) + 300;
    // Each broker has a word on each other every second. Of many brokers, to replicate what their
    // watches were told would be most of the work; members have a next word soon.
    const bool is_simulated_cluster = is_in_virtual_time(settings_.world) && size() > 1;
    const auto qos = is_simulated_cluster ? mqttsn::Qos::at_most_once : mqttsn::Qos::at_least_once;
    for (std::size_t i = 0; i < size(); ++i) {
        brokers_[i].watch = std::make_unique<BrokerWatch>(
            world_.surroundings(), brokers_[i].address, watch_of(i), timing, on_change, qos);
    }
}

bool CellBrokers::are_whole() const {
    const auto first = brokers_.front().watch->leader();
    return first && std::ranges::all_of(brokers_, [&](const Broker& broker) {
               return broker.is_at_home_in_view_of(size()) && broker.watch->leader() == first;
           });
}

std::string CellBrokers::what_they_see() const {
    std::string sentence = "seen alive:";
    for (const Broker& broker : brokers_) {
        if (broker.watch == nullptr) continue;
        sentence += " " + broker.name + " sees " + std::to_string(broker.watch->alive()) +
                    " in a view of " +
                    std::to_string(broker.watch->members_in_view_of(broker.name)) + " led by " +
                    broker.watch->leader().value_or("nobody") + ";";
    }
    sentence.pop_back();
    return sentence;
}

std::optional<std::size_t> CellBrokers::leader() const {
    const auto up = std::ranges::find_if(brokers_, [](const auto& b) { return !b.is_down; });
    if (up == brokers_.end()) return std::nullopt;
    const auto name = up->watch->leader();
    const auto found =
        std::ranges::find_if(brokers_, [&](const auto& b) { return b.name == name; });
    if (found == brokers_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - brokers_.begin());
}

void CellBrokers::start(std::size_t number) {
    Broker& broker = brokers_[number];
    ++broker.lives;
    if (const BrokerStatus* own = broker.own_status()) broker.former_incarnation = own->incarnation;
    const std::string life = broker.lives == 1 ? "" : "-life-" + std::to_string(broker.lives);
    world_.start(number, {.name = broker.name,
                          .arguments = arguments_of(number),
                          .trace = trace_of_(broker.name + life)});
    broker.is_down = false;
}

void CellBrokers::kill(std::size_t number) {
    brokers_[number].is_down = true;
    world_.kill(number);
}

void CellBrokers::ask_to_stop(std::size_t number) {
    brokers_[number].is_down = true;
    world_.ask_to_stop(number);
}

void CellBrokers::stop_all() {
    for (Broker& broker : brokers_) broker.watch.reset();
    world_.stop_all();
}

void CellBrokers::check() {
    for (std::size_t i = 0; i < size(); ++i) {
        if (brokers_[i].is_down || !world_.has_ended(i)) continue;
        throw RunFailed("broker " + brokers_[i].name + " ended unexpectedly, " +
                        world_.how_it_ended(i));
    }
}

void CellBrokers::begin_usage() {
    for (std::size_t i = 0; i < size(); ++i) {
        Broker& broker = brokers_[i];
        broker.usage_before = world_.usage_of(i).value_or(ProcessUsage{});
        broker.usage_from = world_.now();
        broker.octets_before = broker.octets_sent();
    }
}

void CellBrokers::end_usage(std::size_t number) {
    Broker& broker = brokers_[number];
    if (std::exchange(broker.is_measured, true)) return;  // struck down before
    broker.usage = world_.usage_of(number);
    broker.usage_time = world_.now() - broker.usage_from;
    const std::uint64_t sent = broker.octets_sent();
    // A broker that began anew counts from zero, and one that nobody hears of has sent nothing.
    broker.octets = sent < broker.octets_before ? sent : sent - broker.octets_before;
}

}  // namespace romano::experiments
