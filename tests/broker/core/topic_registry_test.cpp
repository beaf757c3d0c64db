// Topic ids of one client: MQTT-SN 1.2 section 7.3, G15.

#include "broker/core/topic_registry.h"

#include <gtest/gtest.h>

#include <string>

namespace romano::broker::topic_registry_test {
namespace {

using mqttsn::TopicId;

TEST(TopicRegistry, CountsUpFromOneAndFindsByNameAndId) {
    TopicRegistry registry;
    for (std::uint16_t i = 1; i <= 2000; ++i) {
        EXPECT_EQ(registry.add("topic/" + std::to_string(i)), TopicId{i});
    }
    for (std::uint16_t i = 1; i <= 2000; ++i) {
        const std::string name = "topic/" + std::to_string(i);
        ASSERT_EQ(registry.find(name), TopicId{i});
        ASSERT_EQ(registry.at(TopicId{i})->name, name);
    }
    EXPECT_EQ(registry.find("other"), mqttsn::no_topic_id);
    EXPECT_EQ(registry.at(mqttsn::no_topic_id), nullptr);
    EXPECT_EQ(registry.at(mqttsn::reserved_topic_id), nullptr);
    EXPECT_EQ(registry.at(TopicId{2001}), nullptr);
}

TEST(TopicRegistry, NeverGivesReservedIds) {
    TopicRegistry registry;
    for (int i = 1; i <= 0xFFFE; ++i) registry.add(std::to_string(i));
    EXPECT_EQ(registry.find(std::to_string(0xFFFE)), TopicId{0xFFFE});
    EXPECT_EQ(registry.add("one more"), mqttsn::no_topic_id);
}

TEST(TopicRegistry, GoesOnAfterTheIdsOfAnImage) {
    TopicRegistry registry;
    registry.restore(std::vector<TopicBinding>{{TopicId{1}, "a", true}, {TopicId{4}, "d", false}});
    EXPECT_EQ(registry.find("d"), TopicId{4});
    EXPECT_EQ(registry.at(TopicId{2}), nullptr);
    EXPECT_EQ(registry.add("e"), TopicId{5});
    EXPECT_EQ(registry.bindings().size(), 3u);
}

}  // namespace
}  // namespace romano::broker::topic_registry_test
