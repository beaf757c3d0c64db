// One datagram for many that listen (romano/mqttsn/cell.md), lost for each by itself: every promise
// is kept beside clients that do not listen, and when brokers die and robots roam.

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "overlay/sim/lone_world.h"
#include "overlay/sim/promises.h"
#include "overlay/sim/run.h"
#include "tests/overlay/sim/cluster_scenario.h"

namespace romano::sim::cell_seeds_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr LinkQuality good{};
constexpr LinkQuality slow{.delay_min = 1ms, .delay_max = 30ms};

broker::BrokerOptions with_a_cell() {
    broker::BrokerOptions options = LoneWorld::quick_broker();
    options.cell_group = World::cell_group();
    return options;
}

/// Loses one in five of the broker's PUBLISHes and of the answers to them; no publisher's, which
/// would say it again, and that is another message at QoS 1.
ClientNetwork::Filter lossy(std::uint64_t seed) {
    return [random = Random{seed}](const Endpoint& from, const Endpoint&, Bytes datagram) mutable {
        const bool is_from_broker = from == World::service_address(0);
        const auto type = static_cast<mqttsn::MsgType>(datagram[1]);
        const auto lost = is_from_broker ? mqttsn::MsgType::publish : mqttsn::MsgType::puback;
        return type == lost && random.below(5) == 0;
    };
}

/// Nobody gets a message of QoS 0 twice, nor one of QoS 1 twice without DUP.
void expect_no_doubles(const Ledger& ledger) {
    std::map<std::tuple<std::string, std::string, std::uint32_t>, int> first_copies;
    for (const Reception& reception : ledger.receptions) {
        if (reception.dup || reception.qos == Qos::exactly_once) continue;
        const int copies =
            ++first_copies[{reception.subscriber, reception.publisher, reception.number}];
        EXPECT_EQ(copies, 1) << reception.subscriber << " hears " << reception.number << " of "
                             << reception.publisher << " again";
    }
}

class LossyCell : public testing::TestWithParam<std::uint64_t> {};

TEST_P(LossyCell, KeepsEveryPromiseBesideClientsThatDoNotListen) {
    LoneWorld world(GetParam(), with_a_cell());
    for (int i = 0; i < 10; ++i) {
        RobotOptions robot;
        robot.subscriptions = {{"common", i == 7 ? Qos::at_most_once : Qos::exactly_once}};
        if (i < 8) robot.cell_group = World::cell_group();
        if (i > 7) robot.clean_session = false;
        if (i % 3 == 0) {
            robot.topics = {"common"};
            robot.qos = {Qos::at_most_once, Qos::at_least_once, Qos::at_least_once,
                         Qos::exactly_once};
            robot.publish_every_min = 20ms;
            robot.publish_every_max = 300ms;
        }
        world.add_robot(robot);
    }
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).start();
    ASSERT_TRUE(world.run_until([&] { return world.robots_are_idle(); }, 10s));
    world.clients().set_quality(slow);
    world.clients().set_filter(lossy(GetParam()));
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).begin_publishing();
    world.run_for(20s);
    for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).end_publishing();
    world.clients().set_quality(good);
    world.clients().set_filter({});
    ASSERT_TRUE(world.run_until([&] { return world.robots_are_idle(); }, 30s));
    world.run_for(20s);

    Violations violations;
    judge_safety(world.ledger(), {}, violations);
    judge_completeness(world.ledger(), {}, violations);
    EXPECT_TRUE(violations.empty()) << "seed " << GetParam() << "\n" << to_text(violations);
    expect_no_doubles(world.ledger());
    EXPECT_GT(world.clients().sent_to_groups(), 50U) << "seed " << GetParam();
}

INSTANTIATE_TEST_SUITE_P(Seeds, LossyCell, testing::Range(std::uint64_t{1}, std::uint64_t{9}));

/// The broker dies when its datagram has left, and before most have answered.
TEST(DyingCell, IsRepairedByTheHeir) {
    ClusterWorldOptions options;
    options.has_cells = true;
    Scenario scenario(options);
    for (int i = 0; i < 6; ++i) {
        RobotOptions robot;
        robot.name = "listener" + std::to_string(i);
        robot.subscriptions = {{"common", Qos::at_least_once}};
        robot.cell_group = World::cell_group();
        scenario.world.add_robot(robot);
    }
    Robot& talker = scenario.add("talker", 1, "", "");
    scenario.begin();
    const std::uint64_t before = scenario.world.clients().sent_to_groups();
    // Half of the listeners are out of reach for the datagram itself.
    scenario.world.clients().set_filter([](const Endpoint&, const Endpoint& to, Bytes datagram) {
        const bool is_to_the_cell = datagram.size() > 2 && (datagram[2] & 3U) == 3U;
        return datagram[1] == 0x0C && is_to_the_cell && to.address[3] % 2 == 0;
    });
    ASSERT_TRUE(talker.publish("common", Qos::at_least_once));
    ASSERT_TRUE(scenario.world.run_until(
        [&] { return scenario.world.clients().sent_to_groups() > before; }, 5s, 1ms));
    scenario.world.broker(0).crash();
    const auto all_have_it = [&] {
        std::set<std::string> having;
        for (const auto& reception : scenario.world.ledger().receptions) {
            having.insert(reception.subscriber);
        }
        return having.size() == 6;
    };
    EXPECT_TRUE(scenario.world.run_until(all_have_it, 10s));
    scenario.world.clients().set_filter({});

    ASSERT_TRUE(talker.publish("common", Qos::at_least_once));
    EXPECT_TRUE(scenario.world.run_until(
        [&] { return scenario.world.clients().sent_to_groups() > before + 1; }, 5s))
        << "the heir speaks to the cell of the address that it took over";
    scenario.world.run_for(5s);
    Violations violations;
    judge_safety(scenario.world.ledger(), {}, violations);
    judge_completeness(scenario.world.ledger(), {}, violations);
    EXPECT_TRUE(violations.empty()) << to_text(violations);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(scenario.world.robot(i).connects(), 1U);
}

void keep_every_promise(const SeedRange& seeds, std::vector<Fault> faults) {
    RunOptions options;
    options.has_cells = true;
    options.robots = 9;
    options.faults = std::move(faults);
    options.faults_last = 2500ms;
    std::uint64_t sent_to_cells = 0;
    run_seeds(seeds, options, [&](const RunResult& run) {
        sent_to_cells += run.sent_to_cells;
        EXPECT_TRUE(run.is_good())
            << "seed " << run.seed << " (" << run.setting << ")\n"
            << to_text(run.violations) << "again: " << replay_command(run.seed, options);
    });
    EXPECT_GT(sent_to_cells, 100U);
}

TEST(CellWorlds, KeepEveryPromise) {
    keep_every_promise({1, 10}, {});
}
TEST(CellWorlds, KeepEveryPromiseThroughCrashes) {
    keep_every_promise({11, 20}, {Fault::crash});
}
TEST(CellWorlds, KeepEveryPromiseWhereRobotsRoamSleepAndDie) {
    keep_every_promise({21, 30}, {Fault::roam, Fault::sleep, Fault::die, Fault::crash});
}
TEST(CellWorlds, KeepEveryPromiseOnBadLinks) {
    keep_every_promise({31, 40}, {Fault::bad_links, Fault::stop});
}

}  // namespace
}  // namespace romano::sim::cell_seeds_test
