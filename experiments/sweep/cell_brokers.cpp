#include "experiments/sweep/cell_brokers.h"

#include <algorithm>
#include <chrono>

#include "broker/net/clock.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

/// How long brokers get to end by themselves.
constexpr auto stop_patience = 2s;

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
    const std::string home = address.address().to_string() + ":" + std::to_string(address.port());
    return own->view_members.size() == members && watch->alive() == members &&
           std::ranges::count(own->addresses, home) > 0;
}

CellBrokers::CellBrokers(const SweepSettings& settings, const Cell& cell,
                         const std::string& network, const std::filesystem::path& program,
                         const ResultsFolder& results)
    : settings_(settings), cell_(cell), network_(network), program_(program), results_(results) {
    if (cell.brokers > 1) {
        domain_ = claim_domain(settings.domain_base, domains_in_turn, cell.number - 1);
        if (!domain_) {
            throw RunFailed("none of the DDS domains " + std::to_string(settings.domain_base) +
                            " to " + std::to_string(settings.domain_base + domains_in_turn - 1) +
                            " is free");
        }
    }
    if (cell.fault == Fault::cut) {
        lan_.emplace(static_cast<int>(cell.brokers) + 1);
        if (!lan_->why_not().empty()) throw RunFailed("fault `cut`: " + lan_->why_not());
    }
    brokers_.resize(cell.brokers);
    for (std::size_t i = 0; i < size(); ++i) {
        brokers_[i].name = "b" + std::to_string(i + 1);
        brokers_[i].address = {boost::asio::ip::make_address(address_text(i)), settings_.port};
    }
    for (std::size_t i = 0; i < size(); ++i) start(i);  // each may have to name all (voters)
}

std::string CellBrokers::address_text(std::size_t number) const {
    // A machine's address for its clients is not the one that it has itself: it can move.
    if (lan_) return "10.60.0." + std::to_string(100 + host_of(number));
    // Another network for each cell: nothing of an earlier one can answer.
    return network_ + "." + std::to_string(cell_.number % 250 + 1) + "." +
           std::to_string(number + 1);
}

std::vector<std::string> CellBrokers::arguments_of(std::size_t number) const {
    std::vector<std::string> arguments = {
        "--name", brokers_[number].name, "--listen",
        address_text(number) + ":" + std::to_string(settings_.port)};
    arguments.insert(arguments.end(), settings_.broker_options.begin(),
                     settings_.broker_options.end());
    if (cell_.brokers == 1) return arguments;
    const std::vector<std::string> cluster = {"--domain",    std::to_string(domain_->domain),
                                              "--interface", lan_ ? "eth0" : "lo",
                                              "--elector",   cell_.elector,
                                              "--detector",  cell_.detector,
                                              "--acks",      cell_.acks};
    arguments.insert(arguments.end(), cluster.begin(), cluster.end());
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

void CellBrokers::watch(boost::asio::io_context& io, const std::function<void()>& on_change) {
    // A broker that does not listen yet is asked again soon, as long as we are willing to wait.
    client::Timing timing;
    timing.t_retry = 100ms;
    timing.n_retry = static_cast<int>(settings_.start_within / 100ms) + 300;
    const auto there = where_robots_are();
    for (Broker& broker : brokers_) {
        broker.watch = std::make_unique<BrokerWatch>(io, broker.address, "watch-" + broker.name,
                                                     timing, on_change);
    }
}

std::optional<Lan::On> CellBrokers::where_robots_are() const {
    if (!lan_) return std::nullopt;
    return std::optional<Lan::On>{std::in_place, *lan_, host_of(size())};
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
    std::optional<Lan::On> there;
    if (lan_) there.emplace(*lan_, host_of(number));
    try {
        broker.process =
            std::make_unique<BrokerProcess>(broker.name, program_, arguments_of(number),
                                            results_.trace_file(cell_, broker.name + life));
    } catch (const std::runtime_error& error) {
        throw RunFailed(error.what());
    }
    broker.is_down = false;
}

void CellBrokers::kill(std::size_t number) {
    brokers_[number].is_down = true;
    brokers_[number].process->kill();
}

void CellBrokers::ask_to_stop(std::size_t number) {
    brokers_[number].is_down = true;
    brokers_[number].process->ask_to_stop();
}

void CellBrokers::stop_all() {
    for (Broker& broker : brokers_) broker.watch.reset();
    for (Broker& broker : brokers_) {
        if (broker.process) broker.process->ask_to_stop();
    }
    for (Broker& broker : brokers_) {
        if (broker.process) broker.process->stop(stop_patience);
    }
}

void CellBrokers::check() {
    for (Broker& broker : brokers_) {
        if (broker.is_down || !broker.process->has_ended()) continue;
        throw RunFailed("broker " + broker.name + " ended unexpectedly, " +
                        broker.process->how_it_ended());
    }
}

void CellBrokers::begin_usage() {
    for (Broker& broker : brokers_) {
        broker.usage_before = usage_of(broker.process->pid()).value_or(ProcessUsage{});
        broker.usage_from = net::now();
        broker.octets_before = broker.octets_sent();
    }
}

void CellBrokers::end_usage(std::size_t number) {
    Broker& broker = brokers_[number];
    if (broker.usage) return;  // struck down before
    broker.usage = usage_of(broker.process->pid());
    broker.usage_time = net::now() - broker.usage_from;
    broker.octets = broker.octets_sent() - broker.octets_before;
}

}  // namespace romano::experiments
