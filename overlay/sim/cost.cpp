#include "overlay/sim/cost.h"

#include <algorithm>
#include <string>

#include "overlay/sim/cluster_world.h"
#include "overlay/sim/settlement.h"

namespace romano::sim {

using namespace std::chrono_literals;
using mqttsn::Qos;

namespace {

double in_seconds(std::chrono::nanoseconds duration) {
    return std::chrono::duration<double>(duration).count();
}

/// Robot i publishes on its own topic; the robot of the next broker listens.
void add_robots(ClusterWorld& world, const CostOptions& options) {
    const std::size_t count = options.brokers * options.robots_per_broker;
    for (std::size_t i = 0; i < count; ++i) {
        RobotOptions robot;
        robot.broker = World::service_address(i % options.brokers);
        robot.topics = {"pose/" + std::to_string(i)};
        robot.subscriptions = {{"pose/" + std::to_string((i + 1) % count), Qos::at_least_once}};
        robot.qos = {Qos::at_least_once};
        robot.publish_every_min = options.publish_every / 2;
        robot.publish_every_max = options.publish_every * 3 / 2;
        world.add_robot(std::move(robot));
    }
}

/// What was counted up to now, over all brokers.
struct Counted {
    explicit Counted(ClusterWorld& world) {
        for (std::size_t i = 0; i < world.broker_count(); ++i) {
            core_time += world.broker(i).core_time();
            add(world.peers().sent_by(World::broker_node(i)), sent);
            add(world.peers().received_by(World::broker_node(i)), received);
        }
        for (const auto& [key, message] : world.ledger().sent)
            acknowledged += bool{message.acknowledged};
    }

    static void add(const TrafficByDelivery& traffic, std::array<Traffic, 4>& sum) {
        for (const auto& [delivery, counted] : traffic) {
            Traffic& of = sum.at(static_cast<std::size_t>(delivery));
            of.messages += counted.messages;
            of.octets += counted.octets;
        }
    }

    std::chrono::nanoseconds core_time{0};
    std::array<Traffic, 4> sent{};
    std::array<Traffic, 4> received{};
    std::uint64_t acknowledged = 0;
};

Rates rates_of(const std::array<Traffic, 4>& before, const std::array<Traffic, 4>& after,
               double broker_seconds) {
    Rates rates;
    for (std::size_t i = 0; i < rates.size(); ++i) {
        rates[i].messages_per_s =
            static_cast<double>(after[i].messages - before[i].messages) / broker_seconds;
        rates[i].octets_per_s =
            static_cast<double>(after[i].octets - before[i].octets) / broker_seconds;
    }
    return rates;
}

}  // namespace

Cost cost_of(const CostOptions& options) {
    ClusterWorldOptions world_options;
    world_options.seed = options.seed;
    world_options.brokers = options.brokers;
    world_options.are_invariants_judged = false;
    world_options.cluster.acks = options.acks;
    world_options.cluster.beacon_every = options.beacon_every;
    world_options.cluster.detection_timeout = options.detection_timeout;
    world_options.peers.octets_of = options.octets_of;
    ClusterWorld world(world_options);
    add_robots(world, options);
    world.start_brokers();
    const auto agree = [&] { return !disagreement(world); };
    Cost cost;
    cost.is_settled = world.run_until(agree, 20 * options.detection_timeout + 5s);
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).start();
    cost.is_settled =
        world.run_until([&] { return world.robots_are_idle(); }, 5s) && cost.is_settled;
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).begin_publishing();
    world.run_for(200ms);

    const Counted before(world);
    world.run_for(options.lasts);
    const Counted after(world);
    cost.is_settled = cost.is_settled && agree();
    const double seconds = in_seconds(options.lasts);
    const double broker_seconds = seconds * static_cast<double>(options.brokers);
    cost.publishes_per_s = static_cast<double>(after.acknowledged - before.acknowledged) / seconds;
    cost.sent = rates_of(before.sent, after.sent, broker_seconds);
    cost.received = rates_of(before.received, after.received, broker_seconds);
    cost.core_share = in_seconds(after.core_time - before.core_time) / broker_seconds;
    return cost;
}

}  // namespace romano::sim
