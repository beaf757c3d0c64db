#include "experiments/watch/broker_status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace romano::experiments::broker_status_test {
namespace {

using ::testing::ElementsAre;

TEST(BrokerStatus, ReadsWhatABrokerPublishes) {
    const auto status = parse_broker_status(R"({
        "name": "b1", "alive": true, "leader": true, "rank": 7, "condition": 75, "sessions": 12, "connected": 11,
        "addresses": ["127.0.0.1:1883", "[::1]:1883"], "cannot_take": 2, "incarnation": 1767225600000000000,
        "view": {"term": 3, "leader": "b1", "count": 2, "members": ["b1", "b2"]},
        "transport_octets_sent": 123456, "longest_turn_us": 1500, "cpu_percent": 12,
        "does_not_hear": ["r3"],
        "disagrees": {"predefined": {"b1": "1=robots/pose", "b2": "1=robots/stop"}}})");
    ASSERT_TRUE(status);
    EXPECT_EQ(status->name, "b1");
    EXPECT_TRUE(status->alive);
    EXPECT_TRUE(status->leader);
    EXPECT_EQ(status->rank, 7u);
    EXPECT_EQ(status->condition, 75u);
    EXPECT_EQ(status->sessions, 12u);
    EXPECT_EQ(status->connected, 11u);
    EXPECT_THAT(status->addresses, ElementsAre("127.0.0.1:1883", "[::1]:1883"));
    EXPECT_EQ(status->cannot_take, 2u);
    EXPECT_EQ(status->incarnation, 1767225600000000000u);
    EXPECT_EQ(status->view_term, 3u);
    EXPECT_THAT(status->view_members, ElementsAre("b1", "b2"));
    EXPECT_EQ(status->transport_octets_sent, 123456u);
    EXPECT_EQ(status->longest_turn_us, 1500u);
    EXPECT_EQ(status->cpu_percent, 12u);
    EXPECT_EQ(status->does_not_hear, std::vector<std::string>{"r3"});
    EXPECT_EQ(status->disagrees.at("predefined").at("b2"), "1=robots/stop");
}

TEST(BrokerStatus, KeepsDefaultsForWhatIsMissing) {
    const auto status = parse_broker_status(R"({"name": "b1", "new": [1], "rank": null})");
    ASSERT_TRUE(status);
    EXPECT_FALSE(status->alive);
    EXPECT_FALSE(status->condition);
    EXPECT_FALSE(status->cpu_percent);
    EXPECT_TRUE(status->view_members.empty());
}

TEST(BrokerStatus, IsNoneForOtherText) {
    for (const char* text :
         {"", "hello", "[]", "{}", R"({"name": 3})", R"({"name": "b", "rank": "x"})"}) {
        EXPECT_FALSE(parse_broker_status(text)) << text;
    }
}

}  // namespace
}  // namespace romano::experiments::broker_status_test
