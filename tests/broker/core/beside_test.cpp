// What the broker core does for services that its owner runs beside it: told publishes, own
// publishes, and clients that are held back.

#include <gtest/gtest.h>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::beside_test {
namespace {

BrokerOptions observing_options() {
    BrokerOptions options = logging_options();
    options.observed_topics = {"init"};
    return options;
}

class Beside : public ::testing::Test {
protected:
    Beside() {
        robot.connects();
        watcher.connects();
    }
    void hold(bool held) {
        broker.core.hold(broker.now, "watcher", held, broker.actions);
        broker.drain();
    }
    void publish(std::string_view topic, std::string_view payload, bool retain) {
        broker.core.publish(broker.now, topic, as_octets(payload), Qos::at_least_once, retain,
                            broker.actions);
        broker.drain();
    }

    ScriptedBroker broker{observing_options()};
    ScriptedClient robot{broker, "robot"};
    ScriptedClient watcher{broker, "watcher"};
};

TEST_F(Beside, WhatAClientPublishesOnAnObservedTopicIsToldOnceWithItsPublisher) {
    const TopicId init = robot.registers("init");
    const TopicId other = robot.registers("other");
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
        robot.publishes(init, "hello", qos);
        robot.publishes(other, "hello", qos);
    }
    ASSERT_EQ(broker.observations.size(), 3u);
    for (const Observation& told : broker.observations) {
        EXPECT_EQ(told.publisher, "robot");
        EXPECT_EQ(told.topic, "init");
        EXPECT_EQ(told.payload, octets_of("hello"));
    }
}

TEST(NeverRetained, IsDeliveredButKeptForNobodyWhoeverSendsIt) {
    BrokerOptions options = logging_options();
    options.never_retained = [](std::string_view topic, Bytes payload) {
        return topic == "common" && as_text(payload) == "drive";
    };
    ScriptedBroker broker{options};
    ScriptedClient commander{broker, "commander"};
    ScriptedClient robot{broker, "robot"};
    commander.connects();
    robot.connects();
    robot.subscribes("common");
    const TopicId common = commander.registers("common");
    commander.publishes(common, "stand", Qos::at_least_once, true);
    commander.publishes(commander.registers("words"), "drive", Qos::at_least_once, true);
    robot.hears_publish("stand", Qos::at_least_once);
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
        commander.publishes(common, "drive", qos, true);
        EXPECT_FALSE(robot.hears_publish("drive", qos).retain);
    }
    broker.core.publish(broker.now, "common", as_octets("drive"), Qos::at_most_once, true,
                        broker.actions, "uplink/1");
    for (Action& action : broker.actions.list()) {
        if (const auto* append = std::get_if<Append>(&action)) {
            EXPECT_FALSE(std::get<Published>(*append->event).message->retain);
        }
    }
    EXPECT_EQ(broker.dropped(Drop::never_retained), 4u);
    // From a store, a snapshot or a peer of an earlier version.
    const LogId peer{broker_id_of("b2"), 1};
    const MessagePtr old{Message{.topic = "common",
                                 .payload = octets_of("drive"),
                                 .retain = true,
                                 .position = {peer, 1},
                                 .published_at = HybridTime{~0ULL >> 1U}}};
    broker.core.put_retained(old);
    broker.core.on_peer_message(broker.now, old, broker.actions);
    EXPECT_EQ(broker.dropped(Drop::never_retained), 6u);
    ASSERT_EQ(broker.core.retained().size(), 2u);
    EXPECT_EQ(as_text(broker.core.retained()[0]->payload), "stand") << "what was kept before stays";
    EXPECT_EQ(broker.core.retained()[1]->topic, "words") << "it goes by the topic too";
}

TEST(NeverRetained, NeedsNoRoomAmongTheRetainedMessages) {
    BrokerOptions options = logging_options();
    options.limits.retained_messages = 1;
    options.never_retained = [](std::string_view, Bytes payload) {
        return as_text(payload) == "drive";
    };
    ScriptedBroker broker{options};
    ScriptedClient commander{broker, "commander"};
    ScriptedClient robot{broker, "robot"};
    commander.connects();
    robot.connects();
    commander.publishes(commander.registers("map"), "hall", Qos::at_least_once, true);
    const TopicId common = commander.registers("common");
    robot.subscribes("common");
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
        commander.publishes(common, "drive", qos, true);
        robot.hears_publish("drive", qos);
    }
    broker.core.set_full(true);
    commander.publishes(common, "drive", Qos::at_most_once, true);
    robot.hears_publish("drive");
    ScriptedClient stranger{broker, "stranger"};
    stranger.says(Publish{false, Qos::without_connection, true, TopicIdType::normal, TopicId{6},
                          no_msg_id, as_octets("commondrive")});
    robot.hears_publish("drive");
    EXPECT_EQ(broker.dropped(Drop::no_room), 0u);
}

TEST_F(Beside, ARepeatedQos2PublishIsNotToldAgain) {
    const TopicId init = robot.registers("init");
    Publish publish{false, Qos::exactly_once, false, TopicIdType::normal, init, MsgId{9}, {}};
    robot.says(publish);
    publish.dup = true;
    robot.says(publish);
    EXPECT_EQ(broker.observations.size(), 1u);
}

TEST_F(Beside, TheBrokersOwnPublishIsLoggedDeliveredAndRetained) {
    watcher.subscribes("$ROMANO/nodes/7");
    publish("$ROMANO/nodes/7", "here", true);
    watcher.hears_publish("here", Qos::at_least_once);
    ASSERT_TRUE(std::holds_alternative<Published>(broker.log.at(broker.log.size() - 3)));
    ASSERT_EQ(broker.core.retained("$ROMANO/nodes/+").size(), 1u);
    EXPECT_EQ(broker.core.retained("$ROMANO/nodes/+")[0]->topic, "$ROMANO/nodes/7");
    publish("$ROMANO/nodes/7", "", true);
    EXPECT_TRUE(broker.core.retained("$ROMANO/nodes/+").empty());
    broker.expects_mirror_to_agree();
}

TEST_F(Beside, WhatAHeldClientShouldHearWaitsInOrderAtEveryQos) {
    watcher.subscribes("a");
    const TopicId a = robot.registers("a");
    hold(true);
    robot.publishes(a, "1", Qos::at_least_once);
    robot.publishes(a, "2", Qos::exactly_once);
    robot.publishes(a, "3", Qos::at_most_once);
    watcher.hears_nothing();
    hold(false);
    watcher.hears_publish("1", Qos::at_least_once);
    watcher.hears_publish("2", Qos::exactly_once);
    watcher.hears_publish("3");
    watcher.hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(Beside, AnOpenExchangeWithAClientThatIsHeldIsFinishedAndNotBegunAnew) {
    watcher.subscribes("a");
    const TopicId a = robot.registers("a");
    robot.publishes(a, "1", Qos::exactly_once);
    const MsgId msg_id = watcher.hears<Publish>().msg_id;
    hold(true);
    robot.publishes(a, "2", Qos::exactly_once);
    watcher.says(Pubrec{msg_id});
    EXPECT_EQ(watcher.hears<Pubrel>().msg_id, msg_id);
    watcher.says(Pubcomp{msg_id});
    watcher.hears_nothing();
    hold(false);
    watcher.hears_publish("2", Qos::exactly_once);
    watcher.hears_nothing();
}

TEST_F(Beside, ACleanConnectEndsTheHold) {
    watcher.subscribes("b");  // or its second CONNECT would be a repetition of the first
    hold(true);
    watcher.connects();
    watcher.subscribes("a");
    robot.publishes(robot.registers("a"), "1");
    watcher.hears_publish("1");
}

}  // namespace
}  // namespace romano::broker::beside_test
