#include "experiments/testbed/testbed_world.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "experiments/sweep/text_file.h"
#include "experiments/testbed/program_order.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr auto begins_within = 30s;  // an earlier session may have to notice that it is alone
constexpr auto stops_within = 20s;
/// Of the brokers' pages, on 127.0.0.1 there.
constexpr std::uint16_t first_metrics_port = 19'883;

bool tells_where_metrics_are(const std::vector<std::string>& options) {
    return std::ranges::any_of(
        options, [](const std::string& option) { return option.starts_with("--metrics"); });
}

}  // namespace

TestbedWorld::TestbedWorld(const SweepSettings& settings, const Cell& cell,
                           const TestbedPlace& place)
    : settings_(settings),
      domain_(settings.domain_base + (cell.number - 1) % domains_in_turn),
      brokers_(cell.brokers) {
    if (cell.clients != "plain")
        throw RunFailed("keys of clients stay on one machine: `clients` is plain here");
    for (std::size_t i = 0; i < brokers_.size(); ++i) brokers_[i].seat = place.seats()[i];
    for (const Broker& broker : brokers_) open(place, broker.seat.host);
    for (auto& [host, machine] : machines_) await_begin(place.connections()[host], machine);
}

void TestbedWorld::open(const TestbedPlace& place, std::size_t host) {
    Machine& machine = machines_[host];
    if (machine.channel) return;
    machine.host = &place.testbed().hosts[host];
    machine.channel = std::make_unique<HostChannel>(
        io(), place.connections()[host],
        [this, &machine](const json& words) { hear(machine, words); });
    machine.channel->begin_asking({{"do", "begin"},
                                   {"interface", machine.host->interface},
                                   {"addresses", place.testbed().addresses()}},
                                  "begun");
}

void TestbedWorld::await_begin(const Ssh& ssh, Machine& machine) {
    std::string why;
    try {
        const json told = machine.channel->await_answer(begins_within);
        if (told.at("begun").get<bool>()) return;
        why = told.value("trouble", "it refuses");
    } catch (const std::exception& error) {
        const std::string said = ssh.connect();
        why = said.empty() ? error.what() : said;
    }
    throw RunFailed(machine.host->name + " cannot be used: " + why);
}

BrokerAddress TestbedWorld::address_of(std::size_t broker) const {
    return {boost::asio::ip::make_address(brokers_[broker].seat.address), settings_.port};
}

void TestbedWorld::start(std::size_t broker, const BrokerLife& life) {
    Broker& started = brokers_[broker];
    Machine& machine = machine_of(broker);
    started.how_it_ended.reset();
    started.usage.reset();
    ProgramOrder order;
    order.number = static_cast<std::uint32_t>(broker);
    order.life = ++started.lives;
    order.program = "romano-broker";
    order.name = life.name;
    order.arguments = life.arguments;
    order.arguments.insert(order.arguments.end(), machine.host->broker_options.begin(),
                           machine.host->broker_options.end());
    if (brokers_.size() == 1) {
        order.lease = started.seat.address;  // a broker alone takes no address by itself
    } else {
        order.arguments.insert(order.arguments.end(), {"--domain", std::to_string(domain_),
                                                       "--interface", machine.host->interface});
    }
    if (!tells_where_metrics_are(order.arguments)) {
        order.metrics_port = static_cast<std::uint16_t>(first_metrics_port + broker);
        order.arguments.insert(order.arguments.end(),
                               {"--metrics", "127.0.0.1:" + std::to_string(order.metrics_port)});
    }
    order.trace = life.trace.filename();
    traces_[order.trace] = life.trace;
    machine.channel->tell({{"do", "start"}, {"order", order}});
}

void TestbedWorld::tell(std::size_t broker, const char* what) {
    machine_of(broker).channel->tell({{"do", what}, {"number", broker}});
}

void TestbedWorld::kill(std::size_t broker) {
    brokers_[broker].usage.reset();
    tell(broker, "kill");
}

void TestbedWorld::ask_to_stop(std::size_t broker) {
    tell(broker, "ask_to_stop");
}

void TestbedWorld::pause(std::size_t broker) {
    tell(broker, "pause");
}

void TestbedWorld::resume(std::size_t broker) {
    tell(broker, "resume");
}

void TestbedWorld::cut(std::size_t broker) {
    tell(broker, "cut");
}

void TestbedWorld::mend(std::size_t broker) {
    tell(broker, "mend");
}

void TestbedWorld::stop_all() {
    for (auto& [number, machine] : machines_) {
        if (machine.channel && !machine.channel->is_gone()) machine.channel->tell({{"do", "stop"}});
    }
    const auto is_over = [](const auto& each) {
        const Machine& machine = each.second;
        return machine.has_stopped || !machine.channel || machine.channel->is_gone();
    };
    run_until(
        now() + stops_within, [&] { return std::ranges::all_of(machines_, is_over); }, [] {});
    for (const auto& [number, machine] : machines_) {
        if (machine.has_stopped || !machine.channel) continue;
        check_presence(machine);
        throw RunFailed(machine.host->name + " did not stop its brokers within " +
                        std::to_string(stops_within.count()) + " s");
    }
}

void TestbedWorld::check_presence(const Machine& machine) {
    if (!machine.channel->is_gone()) return;
    throw RunFailed(machine.host->name + " vanished: " + machine.channel->why_gone());
}

bool TestbedWorld::has_ended(std::size_t broker) {
    const Machine& machine = machine_of(broker);
    if (!machine.trouble.empty()) {
        throw RunFailed(machine.host->name + ": " + machine.trouble);
    }
    check_presence(machine);
    return brokers_[broker].how_it_ended.has_value();
}

std::string TestbedWorld::how_it_ended(std::size_t broker) const {
    return brokers_[broker].how_it_ended.value_or("still running");
}

std::optional<ProcessUsage> TestbedWorld::usage_of(std::size_t broker) const {
    return brokers_[broker].usage;
}

// What comes from elsewhere is looked at, whatever it is.
void TestbedWorld::hear(Machine& machine, const json& words) {
    try {
        if (words.contains("usage")) {
            for (const json& each : words["usage"]) {
                Broker* broker = meant(each.at(0), each.at(1));
                if (broker == nullptr || broker->how_it_ended) continue;
                broker->usage = ProcessUsage{.cpu_s = each.at(2).get<double>(),
                                             .rss_mib = each.at(3).get<double>(),
                                             .rss_peak_mib = each.at(4).get<double>()};
            }
        } else if (words.contains("ended")) {
            Broker* broker = meant(words["ended"], words.at("life"));
            if (broker == nullptr) return;
            broker->how_it_ended = words.at("how").get<std::string>();
            broker->usage.reset();
        } else if (words.contains("stopped")) {
            machine.has_stopped = true;
            keep_files(words);
        } else {
            machine.trouble =
                words.value("trouble", words.value("error", "it says " + words.dump()));
        }
    } catch (const json::exception& error) {
        machine.trouble = std::string{"it says what nobody understands: "} + error.what();
    }
}

TestbedWorld::Broker* TestbedWorld::meant(const json& number, const json& life) {
    const auto broker = number.get<std::size_t>();
    if (broker >= brokers_.size() || brokers_[broker].lives != life.get<std::uint32_t>()) {
        return nullptr;
    }
    return &brokers_[broker];
}

void TestbedWorld::keep_files(const json& words) {
    for (const auto& [name, text] : words.at("traces").items()) {
        const auto known = traces_.find(name);
        if (known != traces_.end()) write_text(known->second, text.get<std::string>());
    }
    for (const auto& [name, text] : words.at("metrics").items()) {
        const auto known = traces_.find(name);
        if (known == traces_.end()) continue;
        auto file = known->second;
        file.replace_filename(file.stem().string() + "-metrics.txt");
        write_text(file, text.get<std::string>());
    }
}

}  // namespace romano::experiments
