#include "experiments/sweep/process_world.h"

#include <chrono>
#include <utility>

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

/// How long brokers get to end by themselves.
constexpr auto stop_patience = 2s;

constexpr std::size_t first_host_address = 100;

}  // namespace

ProcessWorld::ProcessWorld(const SweepSettings& settings, const Cell& cell,
                           const std::string& network, std::filesystem::path program)
    : port_(settings.port),
      // Another network for each cell: nothing of an earlier one can answer.
      subnet_(network + "." + std::to_string(cell.number % 250 + 1) + "."),
      program_(std::move(program)),
      brokers_(cell.brokers) {
    if (cell.brokers > 1) {
        domain_ = claim_domain(settings.domain_base, domains_in_turn, cell.number - 1);
        if (!domain_) {
            throw RunFailed("none of the DDS domains " + std::to_string(settings.domain_base) +
                            " to " + std::to_string(settings.domain_base + domains_in_turn - 1) +
                            " is free");
        }
    }
    if (cell.clients != "plain") keys_.emplace(settings, cell);
    if (cell.fault == Fault::cut) {
        lan_.emplace(static_cast<int>(cell.brokers) + 1);
        if (!lan_->why_not().empty()) throw RunFailed("fault `cut`: " + lan_->why_not());
    }
}

BrokerAddress ProcessWorld::address_of(std::size_t broker) const {
    // A machine's address for its clients is not the one that it has itself: it can move.
    const std::string text = lan_ ? "10.60.0." + std::to_string(first_host_address + broker + 1)
                                  : subnet_ + std::to_string(broker + 1);
    return {boost::asio::ip::make_address(text), port_};
}

void ProcessWorld::start(std::size_t broker, const BrokerLife& life) {
    std::vector<std::string> arguments = life.arguments;
    if (keys_) {
        const auto more = keys_->broker_arguments(life.name);
        arguments.insert(arguments.end(), more.begin(), more.end());
    }
    if (domain_) {
        arguments.insert(arguments.end(), {"--domain", std::to_string(domain_->domain),
                                           "--interface", lan_ ? "eth0" : "lo"});
    }
    std::optional<Lan::On> there;
    if (lan_) there.emplace(*lan_, host_of(broker));
    try {
        brokers_[broker] =
            std::make_unique<BrokerProcess>(life.name, program_, arguments, life.trace);
    } catch (const std::runtime_error& error) {
        throw RunFailed(error.what());
    }
}

void ProcessWorld::stop_all() {
    for (const auto& broker : brokers_) {
        if (broker) broker->ask_to_stop();
    }
    for (const auto& broker : brokers_) {
        if (broker) broker->stop(stop_patience);
    }
}

std::optional<ProcessUsage> ProcessWorld::usage_of(std::size_t broker) const {
    return experiments::usage_of(brokers_[broker]->pid());
}

std::unique_ptr<Port> ProcessWorld::RobotSockets::open_port(const BrokerAddress& broker,
                                                            const std::string& client_id,
                                                            Port::OnDatagram on_datagram) {
    std::optional<Lan::On> there;
    if (world_.lan_) there.emplace(*world_.lan_, host_of(world_.brokers_.size()));
    return open_socket(broker, std::move(on_datagram),
                       world_.keys_ ? world_.keys_->packets_of(client_id) : nullptr);
}

}  // namespace romano::experiments
