#include "experiments/paper/broadcast.h"

#include <algorithm>
#include <chrono>
#include <ratio>
#include <set>
#include <stdexcept>
#include <string>

#include "overlay/radio/layout.h"
#include "overlay/radio/radio_network.h"
#include "overlay/sim/lone_world.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr Duration until_next = 5s;
constexpr std::chrono::seconds keep_alive{3'600};  // no ping is on the air

double milliseconds(Duration time) {
    return std::chrono::duration<double, std::milli>(time).count();
}

sim::LoneWorld world_of(Way way, std::uint64_t seed) {
    broker::BrokerOptions options = sim::LoneWorld::quick_broker();
    if (way == Way::cell) options.cell_group = sim::World::cell_group();
    return sim::LoneWorld(seed, options);
}

/// What was on the air in the cell until now, of router and robots.
double air_ms(const radio::RadioNetwork& network) {
    constexpr double ns_of_ms = std::nano::den / std::milli::den;
    return static_cast<double>(lowpan::air_time_ns(network.sent_by_router(0)) +
                               lowpan::air_time_ns(network.sent_by_robots(0))) /
           ns_of_ms;
}

}  // namespace

std::string_view name_of(Way way) {
    return way == Way::cell ? "cell" : "unicast";
}

BroadcastRun broadcast_run(std::size_t robots, Qos qos, Way way, std::size_t messages,
                           std::uint64_t seed) {
    sim::LoneWorld world = world_of(way, seed);
    sim::RobotOptions on_the_wire;
    on_the_wire.name = "operator";
    world.add_robot(on_the_wire);
    radio::RadioOptions options;
    options.cells.resize(1);
    for (std::size_t i = 0; i < robots; ++i) {
        sim::RobotOptions robot;
        robot.name = "robot" + std::to_string(i);
        robot.subscriptions = {{"common", Qos::at_least_once}};
        robot.keep_alive = keep_alive;
        if (way == Way::cell) robot.cell_group = sim::World::cell_group();
        const sim::Robot& added = world.add_robot(robot);
        options.cells[0].robots.push_back(
            {added.options().address, radio::place_around({}, i, robots)});
    }
    const radio::RadioNetwork network(world, options);
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).start();
    const auto ready = [&] {
        return world.robots_are_idle() && world.ledger().subscriptions.size() == robots;
    };
    if (!world.run_until(ready, 60s)) {
        throw std::runtime_error("the robots of a cell did not connect within a minute");
    }
    world.run_for(2s);
    (void)world.robot(0).publish("common", qos);  // it learns the topic id
    world.run_for(until_next);

    BroadcastRun run;
    const double air_before = air_ms(network);
    for (std::size_t i = 0; i < messages; ++i) {
        const Instant sent = world.now();
        const auto number = world.robot(0).publish("common", qos);
        world.run_for(until_next);
        Instant first = never;
        Instant last = sent;
        std::set<std::string> having;
        for (const sim::Reception& reception : world.ledger().receptions) {
            if (reception.number != number || !having.insert(reception.subscriber).second) continue;
            first = std::min(first, reception.at);
            last = std::max(last, reception.at);
        }
        if (having.empty()) continue;
        run.first_ms += milliseconds(first - sent);
        run.last_ms += milliseconds(last - sent);
        run.heard += static_cast<double>(having.size()) / static_cast<double>(robots);
    }
    const auto count = static_cast<double>(messages);
    run.air_ms = (air_ms(network) - air_before) / count;
    run.first_ms /= count;
    run.last_ms /= count;
    run.heard /= count;
    return run;
}

}  // namespace romano::experiments
