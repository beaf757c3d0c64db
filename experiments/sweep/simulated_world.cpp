#include "experiments/sweep/simulated_world.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "broker/daemon/broker_options.h"
#include "broker/daemon/refusal.h"
#include "overlay/daemon/member_options.h"
#include "overlay/member/status_topic.h"
#include "overlay/sim/cluster_broker.h"
#include "overlay/sim/lone_broker.h"
#include "overlay/sim/seed.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

constexpr Duration step = 1ms;  // of virtual time, from one look to the next

// A reliable message that has not come: on a radio it waits behind others, and is long.
constexpr Duration repeats_on_radio_after = 200ms;

// From exec to the first word to a client or a peer.
constexpr Duration starts_within_min = 50ms;
constexpr Duration starts_within_max = 150ms;

Duration from_ms(double ms) {
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>{ms});
}

sim::LinkQuality quality_of(const SimulatedLink& link) {
    sim::LinkQuality quality;
    quality.delay_min = from_ms(link.delay_min_ms);
    quality.delay_max = from_ms(link.delay_max_ms);
    quality.loss_ppm = static_cast<std::uint32_t>(std::lround(link.loss_percent * 1e4));
    return quality;
}

/// Throws daemon::Refusal.
daemon::Settings settings_of(const std::vector<std::string>& arguments) {
    std::vector<const char*> words{"romano-broker"};
    for (const std::string& argument : arguments) words.push_back(argument.c_str());
    const auto read = daemon::read_command_line(static_cast<int>(words.size()), words.data());
    const auto* texts = std::get_if<daemon::SettingTexts>(&read);
    if (texts == nullptr) throw daemon::Refusal("no options that a broker runs with");
    return daemon::check(*texts);
}

/// Empty when there is none.
std::string what_needs_a_machine(const daemon::Settings& settings) {
    if (settings.realtime) return "--realtime";
    if (settings.store) return "--store";
    if (settings.keys) return "--keys";
    if (settings.metrics) return "--metrics";
    if (settings.uplink) return "--uplink";
    if (settings.cluster && settings.cluster->condition_file) return "--condition-file";
    if (!settings.discovery_groups.empty()) return "--discovery-group";
    return "";
}

std::uint64_t seed_of(const Cell& cell) {
    return cell.seed * 1'000'003 + cell.repetition;
}

sim::BrokerNetworkOptions peers_options(const SweepSettings& settings, const Cell& cell,
                                        dds::BodyCodec& codec) {
    sim::BrokerNetworkOptions options;
    options.quality = quality_of(cell.backbone == "wifi" ? settings.wifi : settings.wire);
    if (cell.backbone == "radio") options.repeat_after = repeats_on_radio_after;
    options.overtaking = false;
    options.octets_of = [&codec](const cluster::ClusterMessage& message) {
        return codec.encode(message).size();
    };
    return options;
}

/// What a broker alone says about itself.
std::pair<std::string, std::string> status_of(const std::string& name, const broker::LogId& log,
                                              const Endpoint& address) {
    cluster::Beacon beacon;
    beacon.name = name;
    beacon.log = log;
    beacon.serving = {address};
    const cluster::View view{.number = {.leader = log.broker, .count = 1}, .members = {log}};
    return {overlay::status_topic(name), overlay::to_json({.beacon = beacon,
                                                           .alive = true,
                                                           .leads = true,
                                                           .view = view,
                                                           .member_names = {name},
                                                           .leader_name = name,
                                                           .teller_name = name})};
}

}  // namespace

void check_simulated_broker_options(const SweepSettings& settings) {
    const std::string setting = "`broker_options`: ";
    try {
        std::vector<std::string> arguments{"--name", "b1", "--listen", "10.1.0.1:1883",
                                           "--allow-plain"};
        arguments.insert(arguments.end(), settings.broker_options.begin(),
                         settings.broker_options.end());
        daemon::Settings alone = settings_of(arguments);
        arguments.insert(arguments.end(), {"--domain", "0"});
        const daemon::Settings member = alone.store ? alone : settings_of(arguments);
        const std::string what = what_needs_a_machine(member);
        if (what.empty()) return;
        throw SweepError(setting + what +
                         " means nothing in a simulated world, which has no machine; leave it "
                         "out, or set `world = \"processes\"`");
    } catch (const daemon::Refusal& refused) {
        throw SweepError(setting + refused.what());
    }
}

SimulatedWorld::SimulatedWorld(const SweepSettings& settings, const Cell& cell)
    : world_(seed_of(cell)),
      peers_(world_.events(), world_.trace(), peers_options(settings, cell, codec_),
             sim::seed_of(seed_of(cell), "broker network")),
      random_(sim::seed_of(seed_of(cell), "starts")),
      clients_(world_, clients_node),
      brokers_(cell.brokers) {
    world_.clients().set_quality(quality_of(settings.client_link));
}

SimulatedWorld::~SimulatedWorld() = default;

bool SimulatedWorld::run_until(Instant deadline, const std::function<bool()>& done,
                               const std::function<void()>& look) {
    while (!done()) {
        if (world_.now() >= deadline) return false;
        look();
        world_.events().run_until(std::min(deadline, world_.now() + step));
    }
    return true;
}

std::unique_ptr<sim::BrokerProcess> SimulatedWorld::make_broker(std::size_t broker,
                                                                const BrokerLife& life) {
    const sim::Node node = sim::World::broker_node(broker);
    const Endpoint address = sim::World::service_address(broker);
    const std::uint64_t seed = sim::seed_of(world_.seed(), "broker", broker);
    std::vector<std::string> arguments = life.arguments;
    if (brokers_.size() > 1) arguments.insert(arguments.end(), {"--domain", "0"});
    try {
        const daemon::Settings settings = settings_of(arguments);
        if (!settings.cluster) {
            broker::BrokerOptions options = daemon::broker_options(settings);
            // Of the machine's clock, which a run must not depend on.
            options.log.incarnation = 1;
            options.unix_time_at_zero = {};
            return std::make_unique<sim::LoneBroker>(
                sim::LoneBrokerOptions{
                    .name = life.name,
                    .node = node,
                    .addresses = {address},
                    .broker = options,
                    .system_topics = {status_of(life.name, options.log, address)}},
                world_.events(), world_.clients(), world_.trace(), seed);
        }
        const overlay::MemberOptions member = daemon::member_options(settings);
        sim::ClusterBrokerOptions options;
        options.name = life.name;
        options.node = node;
        options.home_addresses = {address};
        options.cluster = member.cluster;
        options.broker = member.broker;
        return std::make_unique<sim::ClusterBroker>(options, world_.events(), world_.clients(),
                                                    peers_, world_.trace(), seed);
    } catch (const daemon::Refusal& refused) {
        throw RunFailed(refused.what());
    }
}

void SimulatedWorld::start(std::size_t broker, const BrokerLife& life) {
    Broker& one = brokers_[broker];
    if (!one.process) one.process = make_broker(broker, life);
    one.is_starting = true;
    world_.events().after(random_.between(starts_within_min, starts_within_max), [&one] {
        one.process->start();
        one.is_starting = false;
    });
}

void SimulatedWorld::kill(std::size_t broker) {
    brokers_[broker].process->crash();
}

void SimulatedWorld::ask_to_stop(std::size_t broker) {
    static_cast<sim::ClusterBroker&>(*brokers_[broker].process).leave();
}

void SimulatedWorld::pause(std::size_t broker) {
    brokers_[broker].process->stop();
}

void SimulatedWorld::resume(std::size_t broker) {
    brokers_[broker].process->go_on();
}

void SimulatedWorld::cut(std::size_t broker) {
    const sim::Node node = sim::World::broker_node(broker);
    for (std::size_t other = 0; other < brokers_.size(); ++other) {
        if (other == broker) continue;
        peers_.cut(node, sim::World::broker_node(other));
        peers_.cut(sim::World::broker_node(other), node);
    }
    world_.clients().cuts().cut_both(node, clients_node, world_.now());
}

void SimulatedWorld::mend(std::size_t broker) {
    const sim::Node node = sim::World::broker_node(broker);
    for (std::size_t other = 0; other < brokers_.size(); ++other) {
        if (other == broker) continue;
        peers_.join(node, sim::World::broker_node(other));
        peers_.join(sim::World::broker_node(other), node);
    }
    world_.clients().cuts().join(node, clients_node);
    world_.clients().cuts().join(clients_node, node);
}

bool SimulatedWorld::has_ended(std::size_t broker) {
    const Broker& one = brokers_[broker];
    return !one.is_starting && !one.process->is_up();
}

}  // namespace romano::experiments
