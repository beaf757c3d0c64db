// Shipped members and robots that know one address each, for scripted faults. What a robot noticed
// is told by connects(): 1 means nothing.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "overlay/sim/cluster_world.h"
#include "overlay/sim/promises.h"
#include "overlay/sim/settlement.h"
#include "tests/overlay/sim/traced.h"

namespace romano::sim {

class Scenario {
public:
    explicit Scenario(const ClusterWorldOptions& options = {}) : world(options) {
        trace_if_asked(world);
    }

    Robot& add(const std::string& name, std::size_t home, const std::string& topic,
               const std::string& filter,
               std::vector<mqttsn::Qos> qos = {mqttsn::Qos::exactly_once}) {
        RobotOptions options;
        options.name = name;
        options.broker = World::service_address(home);
        if (!topic.empty()) options.topics = {topic};
        if (!filter.empty()) options.subscriptions = {{filter, mqttsn::Qos::exactly_once}};
        options.qos = std::move(qos);
        options.publish_every_min = std::chrono::milliseconds{10};
        options.publish_every_max = std::chrono::milliseconds{30};
        return world.add_robot(options);
    }

    /// A robot at each broker, that publishes on "pose" and gets what all of them publish.
    void add_one_each(const std::vector<mqttsn::Qos>& qos) {
        for (std::size_t home = 0; home < world.broker_count(); ++home) {
            add("robot" + std::to_string(home), home, "pose", "pose", qos);
        }
    }

    /// Brokers and robots are up, agree and are idle.
    void begin() {
        world.start_brokers();
        ASSERT_TRUE(world.run_until([&] { return !disagreement(world); }, std::chrono::seconds{5}))
            << *disagreement(world);
        for (std::size_t i = 0; i < world.robot_count(); ++i) world.robot(i).start();
        ASSERT_TRUE(
            world.run_until([&] { return world.robots_are_idle(); }, std::chrono::seconds{5}));
    }

    void publish(bool on) {
        for (std::size_t i = 0; i < world.robot_count(); ++i) {
            on ? world.robot(i).begin_publishing() : world.robot(i).end_publishing();
        }
    }

    /// Publishing ends, all comes to rest, and every promise was kept.
    void expect_all_promises_kept() {
        expect_nothing_lost();
        Violations violations;
        judge_safety(world.ledger(), {}, violations);
        EXPECT_EQ(to_text(violations), "");
    }

    /// The same without what is not promised to clients that hear both sides of a partition.
    void expect_nothing_lost() {
        publish(false);
        EXPECT_TRUE(world.run_until([&] { return world.robots_are_idle() && !disagreement(world); },
                                    std::chrono::seconds{20}));
        world.run_for(std::chrono::seconds{5});
        Violations violations = world.violations();
        judge_completeness(world.ledger(), {}, violations);
        judge_settlement(world, violations);
        EXPECT_EQ(to_text(violations), "");
    }

    void expect_nobody_noticed() {
        for (std::size_t i = 0; i < world.robot_count(); ++i) {
            EXPECT_EQ(world.robot(i).connects(), 1U) << world.robot(i).name();
        }
    }

    ClusterWorld world;  // three brokers
};

class ClusterScenario : public testing::Test, protected Scenario {
protected:
    explicit ClusterScenario(const ClusterWorldOptions& options = {}) : Scenario(options) {}
};

}  // namespace romano::sim
