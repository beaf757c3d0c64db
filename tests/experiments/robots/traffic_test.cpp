#include "experiments/robots/traffic.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace romano::experiments::traffic_test {
namespace {

using ::testing::ElementsAre;

const QosMix all_levels{{0, 1, 2}};

TEST(SwarmTraffic, GoesToOneOtherRobotAndToTheOwnGroup) {
    const Traffic traffic{Pattern::swarm, 7, 5, all_levels};
    EXPECT_EQ(traffic.clients(), 7u);
    std::set<std::string> topics;
    for (std::uint32_t i = 0; i < 12; ++i) topics.insert(traffic.step(3, i).topic.name);
    EXPECT_THAT(topics, ElementsAre("groups/0", "robots/3"));
    EXPECT_THAT(traffic.step(3, 3).topic.subscribers, ElementsAre(4u));
    EXPECT_THAT(traffic.step(6, 0).topic.subscribers, ElementsAre(0u));
    EXPECT_THAT(traffic.step(6, 3).topic.subscribers, ElementsAre(5u, 6u));
}

TEST(SwarmTraffic, HasEveryLevelOfQosInEachStream) {
    for (const QosMix& mix : {all_levels, QosMix{{0, 1}}, QosMix{{2}}}) {
        const Traffic traffic{Pattern::swarm, 4, 2, mix};
        std::set<std::pair<Stream, int>> seen;
        for (std::uint32_t i = 0; i < 12; ++i) {
            const auto step = traffic.step(1, i);
            seen.insert({step.topic.stream, step.qos});
        }
        EXPECT_EQ(seen.size(), 2 * mix.size());
    }
}

TEST(SwarmTraffic, OfTwoPublishersIsNotInStep) {
    const Traffic traffic{Pattern::swarm, 4, 2, all_levels};
    EXPECT_NE(traffic.step(0, 0).qos, traffic.step(1, 0).qos);
}

TEST(SwarmTraffic, IsHeardAndPublishedByEveryRobot) {
    const Traffic traffic{Pattern::swarm, 6, 3, all_levels};
    for (RobotNumber robot = 0; robot < 6; ++robot) {
        EXPECT_EQ(traffic.heard_by(robot).size(), 2u);
        EXPECT_EQ(traffic.published_by(robot).size(), 2u);
        for (std::uint32_t i = 0; i < 6; ++i) {
            EXPECT_THAT(traffic.published_by(robot),
                        ::testing::Contains(&traffic.step(robot, i).topic));
        }
    }
}

TEST(CommonTraffic, ComesFromOneServerToAllRobots) {
    const Traffic traffic{Pattern::common, 3, 5, all_levels};
    EXPECT_EQ(traffic.clients(), 4u);
    EXPECT_FALSE(traffic.publishes(0));
    EXPECT_TRUE(traffic.publishes(3));
    EXPECT_EQ(traffic.step(3, 9).topic.name, "common");
    EXPECT_THAT(traffic.step(3, 9).topic.subscribers, ElementsAre(0u, 1u, 2u));
    EXPECT_TRUE(traffic.heard_by(3).empty());
}

TEST(CommandTraffic, GoesToEachRobotInTurn) {
    const Traffic traffic{Pattern::commands, 3, 5, all_levels};
    EXPECT_THAT(traffic.step(3, 0).topic.subscribers, ElementsAre(0u));
    EXPECT_THAT(traffic.step(3, 4).topic.subscribers, ElementsAre(1u));
    EXPECT_EQ(traffic.published_by(3).size(), 3u);
    EXPECT_TRUE(traffic.published_by(0).empty());
}

}  // namespace
}  // namespace romano::experiments::traffic_test
