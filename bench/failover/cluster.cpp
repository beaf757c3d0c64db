#include "bench/failover/cluster.h"

#include <boost/asio/ip/address.hpp>
#include <csignal>
#include <stdexcept>
#include <utility>

#include "broker/net/clock.h"

namespace romano::bench {

Cluster::Cluster(const Options& options, const std::filesystem::path& folder, const Fleet* fleet)
    : options_(options), fleet_(fleet) {
    std::filesystem::create_directories(folder);
    for (std::uint32_t n = 1; n <= options.brokers; ++n) {
        std::string name = "b" + std::to_string(n);
        const auto file = folder / (name + ".txt");
        brokers_.push_back({std::move(name), file, TraceTail(file), nullptr, State::running, {}});
    }
    for (std::size_t i = 0; i < brokers_.size(); ++i) start(i);
}

// All are asked before anybody is waited for.
Cluster::~Cluster() {
    for (Broker& broker : brokers_) broker.process->ask_to_stop();
    for (Broker& broker : brokers_) broker.process->stop(std::chrono::seconds{2});
}

std::string Cluster::host(std::size_t broker) const {
    return options_.network + "." + std::to_string(broker + 1);
}

experiments::BrokerAddress Cluster::address(std::size_t broker) const {
    return {boost::asio::ip::make_address(host(broker)), options_.port};
}

std::string Cluster::address_text(std::size_t broker) const {
    return host(broker) + ":" + std::to_string(options_.port);
}

std::optional<experiments::MetricsAddress> Cluster::metrics(std::size_t broker) const {
    if (options_.metrics_port == 0) return std::nullopt;
    return experiments::MetricsAddress{.host = host(broker),
                                       .port = std::to_string(options_.metrics_port)};
}

std::string Cluster::service_text(std::size_t broker) const {
    return scheme_of(options_.packets) + address_text(broker);
}

void Cluster::start(std::size_t number) {
    Broker& broker = brokers_[number];
    // The first one ranks highest and leads.
    std::vector<std::string> arguments = {"--name",      broker.name,
                                          "--listen",    service_text(number),
                                          "--domain",    std::to_string(options_.domain),
                                          "--interface", "lo",
                                          "--rank",      std::to_string(brokers_.size() - number)};
    if (fleet_ != nullptr) {
        const auto with_keys = fleet_->broker_arguments(broker.name);
        arguments.insert(arguments.end(), with_keys.begin(), with_keys.end());
    }
    if (const auto page = metrics(number)) {
        arguments.insert(arguments.end(), {"--metrics", page->host + ":" + page->port});
    }
    arguments.insert(arguments.end(), options_.broker_arguments.begin(),
                     options_.broker_arguments.end());
    broker.process.reset();
    broker.trace.restart();
    broker.process = std::make_unique<experiments::BrokerProcess>(
        broker.name, options_.broker_program, arguments, broker.trace_file);
    broker.state = State::running;
}

void Cluster::kill(std::size_t broker) {
    ::kill(brokers_[broker].process->pid(), SIGKILL);
    brokers_[broker].state = State::killed;
}

void Cluster::pause(std::size_t broker) {
    brokers_[broker].process->pause();
    brokers_[broker].state = State::paused;
}

void Cluster::revive(std::size_t number) {
    Broker& broker = brokers_[number];
    broker.revived = net::now();
    if (broker.state == State::killed) start(number);
    if (broker.state == State::paused) broker.process->resume();
    broker.state = State::running;
}

void Cluster::look() {
    for (Broker& broker : brokers_) {
        broker.trace.read();
        if (broker.state != State::killed && broker.process->has_ended()) {
            throw std::runtime_error("broker " + broker.name +
                                     " ended by itself: " + broker.process->how_it_ended());
        }
    }
}

bool Cluster::serves_its_address(std::size_t number) const {
    const Broker& broker = brokers_[number];
    const std::string home = service_text(number);
    for (const TraceLine& line : broker.trace.lines()) {
        const bool says_so = line.text == "serving " + home ||
                             line.text.find(": serving " + home) != std::string::npos;
        if (says_so && (!line.at || *line.at >= broker.revived)) return true;
    }
    return false;
}

bool Cluster::is_whole() const {
    const TraceLine* first = brokers_.front().trace.last("view ");
    if (first == nullptr) return false;
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        const TraceLine* view = brokers_[i].trace.last("view ");
        if (view == nullptr || view->text != first->text || !serves_its_address(i)) return false;
    }
    return first->text.find(" of " + std::to_string(brokers_.size()) + ",") != std::string::npos;
}

std::optional<std::size_t> Cluster::leader() const {
    for (const Broker& broker : brokers_) {
        const TraceLine* view = broker.trace.last("view ");
        if (broker.state != State::running || view == nullptr) continue;
        for (std::size_t i = 0; i < brokers_.size(); ++i) {
            if (view->text.ends_with(" led by " + brokers_[i].name)) return i;
        }
    }
    return std::nullopt;
}

}  // namespace romano::bench
