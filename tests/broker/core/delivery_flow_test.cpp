// Messages towards a client: MQTT-SN 1.2 sections 6.10, 6.13 and the choices G5, G16, G21, G24,
// G25.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::delivery_flow_test {
namespace {

class Delivering : public ::testing::Test {
protected:
    Delivering() {
        publisher.connects();
        robot.connects();
    }

    void publishes(std::string_view topic, std::string_view data, Qos qos) {
        publisher.publishes(publisher.registers(topic), data, qos);
    }

    void acknowledges(const Publish& publish, ReturnCode code) {
        robot.says(Puback{publish.topic, publish.msg_id, code});
    }

    void gives_a_sign_of_life() {
        robot.says(Pingreq{});
        robot.hears<Pingresp>();
    }

    ScriptedBroker broker{logging_options()};
    ScriptedClient publisher{broker, "publisher"};
    ScriptedClient robot{broker, "robot"};
};

TEST_F(Delivering, QosIsTheLowerOfPublishedAndGranted) {  // 6.10c
    robot.subscribes("a", Qos::at_least_once);
    publishes("a", "2", Qos::exactly_once);
    robot.hears_publish("2", Qos::at_least_once);
    publishes("a", "0", Qos::at_most_once);
    robot.hears_publish("0", Qos::at_most_once);
}

TEST_F(Delivering, OverlappingSubscriptionsGiveOneCopyAtTheHighestQos) {  // M-3.3.5-1
    robot.subscribes("a/b", Qos::at_most_once);
    robot.subscribes("a/+", Qos::exactly_once);
    robot.subscribes("#", Qos::at_least_once);
    publishes("a/b", "x", Qos::exactly_once);
    robot.hears_publish("x", Qos::exactly_once);
    robot.hears_nothing();
}

TEST_F(Delivering, MsgIdsGoFrom1To65535AndBeginAgain) {  // G23: never 0
    robot.subscribes("a");
    const TopicId topic = publisher.registers("a");
    std::vector<bool> used(0x10000);
    for (int i = 0; i < 0x10000 + 10; ++i) {
        publisher.publishes(topic, "x", Qos::at_least_once);
        used[static_cast<std::uint16_t>(robot.hears_publish("x", Qos::at_least_once).msg_id)] =
            true;
    }
    EXPECT_EQ(std::ranges::count(used, true), 0xFFFF);
    EXPECT_FALSE(used[0]);
}

// Its next home may begin it under another id (simulator, seed 2747 as shipped, raft).
TEST_F(Delivering, P3_NothingIsBegunAtAnAddressThatIsSilent) {
    robot.subscribes("a", Qos::exactly_once);
    bool is_silent = true;
    broker.core.set_silence(
        [&](const SessionHeader& to, Instant) { return is_silent && to.via == broker.via; });
    publishes("a", "x", Qos::exactly_once);
    robot.hears_nothing();
    EXPECT_EQ(broker.core.image("robot")->deliveries.at(0).stage, DeliveryStage::queued);
    is_silent = false;
    broker.core.send_again(broker.now, broker.via, 0, 100, broker.actions);
    broker.drain();
    robot.hears_publish("x", Qos::exactly_once);
}

TEST_F(Delivering, UnansweredPublishIsSentAgainWithDup) {  // 6.13c, G5
    robot.subscribes("a");
    publishes("a", "x", Qos::at_least_once);
    const auto first = robot.hears<Publish>();
    EXPECT_FALSE(first.dup);
    const MsgId msg_id = first.msg_id;
    broker.waits(10s);
    const auto again = robot.hears<Publish>();
    EXPECT_TRUE(again.dup);
    EXPECT_EQ(again.msg_id, msg_id);
    acknowledges(again, ReturnCode::accepted);
    broker.waits(1min);
    robot.hears_nothing();
    EXPECT_EQ(broker.core.counters().retransmissions, 1u);
}

// P3: where the client is heard the exchange may be over, and it would take the message for a new
// one.
TEST_F(Delivering, WhoMayBeHeardElsewhereIsAskedBeforeAMessageIsSentAgain) {
    robot.subscribes("a");
    publishes("a", "x", Qos::exactly_once);
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    const SessionJudgement is_elsewhere = [](const SessionHeader&) { return true; };
    const auto time_passes = [&] {
        broker.now += 10s;
        broker.core.on_tick(broker.now, broker.actions, is_elsewhere);
        broker.drain();
    };
    for (int i = 0; i < default_n_retry; ++i) {
        time_passes();
        robot.hears<Pingreq>();
        robot.hears_nothing();
    }
    time_passes();
    robot.hears_nothing();
    robot.says(Pingresp{});
    const auto again = robot.hears<Publish>();
    EXPECT_TRUE(again.dup);
    EXPECT_EQ(again.msg_id, msg_id);
}

TEST_F(Delivering, PubrelIsSentAgainUntilPubcomp) {  // 6.10d
    robot.subscribes("a");
    publishes("a", "x", Qos::exactly_once);
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    robot.says(Pubrec{msg_id});
    robot.hears<Pubrel>();
    broker.waits(10s);
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, msg_id);
    robot.says(Pubrec{msg_id});  // a repetition of what the client said
    EXPECT_EQ(robot.hears<Pubrel>().msg_id, msg_id);
    robot.says(Pubcomp{msg_id});
    broker.waits(1min);
    robot.hears_nothing();
}

TEST_F(Delivering, ClientThatLivesButDoesNotAnswerLosesThatMessageOnly) {  // G5
    robot.subscribes("a");
    publishes("a", "1", Qos::exactly_once);
    publishes("a", "2", Qos::at_least_once);
    for (int sending = 0; sending < 4; ++sending) {
        EXPECT_EQ(as_text(robot.hears<Publish>().data), "1");
        gives_a_sign_of_life();
        broker.waits(10s);
    }
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 1u);
    robot.hears_publish("2", Qos::at_least_once);
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, SilentClientKeepsItsQueueUntilItIsHeard) {  // G5
    robot.subscribes("a");
    publishes("a", "1", Qos::at_least_once);
    publishes("a", "2", Qos::at_least_once);
    broker.waits(10min);
    EXPECT_EQ(robot.unheard(), 5u);  // the last is PINGREQ
    robot.ignores_what_came();
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    EXPECT_TRUE(robot.hears_publish("1", Qos::at_least_once).dup);
    robot.hears<Pingreq>();
    robot.hears_publish("2", Qos::at_least_once);
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering,
       WhoIsThereButTakesOneMessageNeverIsAskedAndGetsTheNext) {  // G5: asymcute's buffer
    robot.subscribes("a");
    publishes("a", "too long", Qos::exactly_once);
    publishes("a", "2", Qos::at_least_once);
    broker.waits(40s);  // all four sendings
    for (int sending = 0; sending < 4; ++sending) robot.hears<Publish>();
    robot.hears<Pingreq>();
    robot.hears_nothing();
    robot.says(Pingresp{});
    for (int sending = 0; sending < 4; ++sending) {  // once more, and it is there each time
        EXPECT_EQ(as_text(robot.hears<Publish>().data), "too long");
        robot.hears<Pingreq>();
        robot.says(Pingresp{});
        broker.waits(10s);
    }
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 1u);
    ASSERT_EQ(broker.notes.size(), 1u);
    EXPECT_NE(broker.notes[0].find("8 octets on 'a'"), std::string::npos) << broker.notes[0];
    robot.hears_publish("2", Qos::at_least_once);
    robot.hears_nothing();
    broker.expects_mirror_to_agree();  // no heir repeats it
}

TEST_F(Delivering, WhoComesBackIntoReachLosesNothing) {  // G5
    robot.subscribes("a");
    publishes("a", "1", Qos::at_least_once);
    robot.hears<Publish>();
    gives_a_sign_of_life();  // and then drives out of reach
    broker.waits(10min);
    robot.ignores_what_came();
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    robot.hears<Publish>();  // lost on the way, as is the next
    broker.waits(10s);
    robot.ignores_what_came();
    broker.waits(10min);
    robot.ignores_what_came();
    robot.says(Pingreq{});
    robot.hears<Pingresp>();
    robot.hears_publish("1", Qos::at_least_once);
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 0u);
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, WhoHasAllTopicIdsGetsNoMessageOfAnotherNameAndPeopleAreTold) {  // P8
    BrokerOptions options = logging_options();
    options.limits.topics_per_session = 2;
    ScriptedBroker small{options};
    ScriptedClient source{small, "source"};
    ScriptedClient monitor{small, "monitor"};
    source.connects();
    monitor.connects();
    monitor.subscribes("#");
    source.publishes(source.registers("m/1"), "1", Qos::at_least_once);
    monitor.hears_register("m/1");
    monitor.hears_publish("1", Qos::at_least_once);
    source.publishes(source.registers("m/2"), "2", Qos::at_least_once);
    monitor.hears_register("m/2");
    monitor.hears_publish("2", Qos::at_least_once);
    EXPECT_TRUE(small.notes.empty());
    ScriptedClient another{small, "another"};
    another.connects();
    another.publishes(another.registers("m/3"), "3", Qos::at_least_once);
    monitor.hears_nothing();
    ASSERT_EQ(small.notes.size(), 1u);
    EXPECT_NE(small.notes[0].find("'m/3'"), std::string::npos) << small.notes[0];
    small.expects_mirror_to_agree();
}

TEST_F(Delivering, WarningsShowNoOctetThatEndsTheLineOrMovesTheCursor) {
    BrokerOptions options = logging_options();
    options.limits.topics_per_session = 1;
    ScriptedBroker small{options};
    ScriptedClient source{small, "source"};
    ScriptedClient monitor{small, "moni\x1b[2Jtor"};
    source.connects();
    monitor.connects();
    monitor.subscribes("#");
    const TopicId topic = source.registers("1\n2");
    source.publishes(topic, "1");
    monitor.hears_register("1\n2");
    monitor.hears_publish("1");
    ScriptedClient another{small, "another"};
    another.connects();
    another.publishes(another.registers("3\n4"), "2");
    source.publishes(topic, "too long", Qos::at_least_once);
    for (int sending = 0; sending < 4; ++sending) {
        monitor.hears<Publish>();
        monitor.says(Pingreq{});
        monitor.hears<Pingresp>();
        small.waits(10s);
    }
    ASSERT_EQ(small.notes.size(), 2u);
    EXPECT_EQ(small.notes[0].find_first_of("\n\x1b"), std::string::npos) << small.notes[0];
    EXPECT_NE(small.notes[0].find("'moni?[2Jtor'"), std::string::npos) << small.notes[0];
    EXPECT_NE(small.notes[0].find("on '3?4'"), std::string::npos) << small.notes[0];
    EXPECT_NE(small.notes[1].find("'moni?[2Jtor'"), std::string::npos) << small.notes[1];
    EXPECT_NE(small.notes[1].find("on '1?2'"), std::string::npos) << small.notes[1];
    EXPECT_EQ(small.notes[1].find_first_of("\n\x1b"), std::string::npos) << small.notes[1];
}

TEST_F(Delivering, UnknownIdIsRegisteredAndPublishedOnceMore) {  // 6.10e, G21
    const TopicId id = robot.subscribes("a");
    publishes("a", "x", Qos::at_least_once);
    const auto first = robot.hears<Publish>();
    const MsgId first_id = first.msg_id;
    acknowledges(first, ReturnCode::invalid_topic_id);
    EXPECT_EQ(robot.hears_register("a"), id);
    const auto second = robot.hears<Publish>();
    EXPECT_NE(second.msg_id, first_id);
    EXPECT_FALSE(second.dup);
    acknowledges(second, ReturnCode::invalid_topic_id);
    EXPECT_EQ(broker.dropped(Drop::refused_by_client), 1u);
    robot.hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, UnknownIdAtQos0IsToldBeforeTheNextMessage) {  // G21
    const TopicId id = robot.subscribes("a");
    publishes("a", "1", Qos::at_most_once);
    robot.hears_publish("1");
    robot.says(Puback{id, no_msg_id, ReturnCode::invalid_topic_id});
    publishes("a", "2", Qos::at_most_once);
    robot.hears_register("a");
    robot.hears_publish("2");
    broker.expects_mirror_to_agree();
}

/// The message overtook its SUBACK; the client learnt the id meanwhile, and ignores REGISTER.
TEST_F(Delivering, UnknownIdAtQos0CostsWhoIgnoresRegisterASecondOnce) {  // G14, G21: RIOT's emcute
    const TopicId id = robot.subscribes("a", Qos::at_most_once);
    publishes("a", "1", Qos::at_most_once);
    robot.hears_publish("1");
    robot.says(Puback{id, no_msg_id, ReturnCode::invalid_topic_id});
    publishes("a", "2", Qos::at_least_once);
    EXPECT_EQ(robot.hears<Register>().topic_id, id);
    broker.waits(1s);
    EXPECT_EQ(robot.hears_publish("2").topic, id);
    publishes("a", "3", Qos::at_most_once);
    robot.hears_publish("3");
    robot.hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, RefusedQos2FallsBackToQos1) {  // G25: RIOT's emcute
    robot.subscribes("a");
    publishes("a", "x", Qos::exactly_once);
    const auto first = robot.hears<Publish>();
    const MsgId first_id = first.msg_id;
    acknowledges(first, ReturnCode::not_supported);
    const auto second = robot.hears<Publish>();
    EXPECT_EQ(second.qos, Qos::at_least_once);
    EXPECT_NE(second.msg_id, first_id);
    EXPECT_FALSE(second.dup);
    acknowledges(second, ReturnCode::accepted);
    robot.hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, RefusedTwiceIsDropped) {  // G25
    robot.subscribes("a", Qos::at_least_once);
    publishes("a", "1", Qos::at_least_once);
    publishes("a", "2", Qos::at_least_once);
    acknowledges(robot.hears<Publish>(), ReturnCode::not_supported);
    acknowledges(robot.hears<Publish>(), ReturnCode::not_supported);
    robot.hears_publish("2", Qos::at_least_once);
    EXPECT_EQ(broker.dropped(Drop::refused_by_client), 1u);
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, RefusedNameIsNotPublishedUntilItIsAskedForAgain) {  // 6.10b, G16
    robot.subscribes("a/#");
    publishes("a/b", "1", Qos::at_least_once);
    const auto told = robot.hears<Register>();
    robot.says(Regack{told.topic_id, told.msg_id, ReturnCode::not_supported});
    publishes("a/b", "2", Qos::at_least_once);
    publishes("a/b", "3", Qos::at_most_once);
    robot.hears_nothing();
    publishes("a/c", "4", Qos::at_least_once);  // the wildcard subscription itself goes on
    robot.hears_register("a/c");
    robot.hears_publish("4", Qos::at_least_once);
    robot.registers("a/b");
    publishes("a/b", "5", Qos::at_least_once);
    robot.hears_publish("5", Qos::at_least_once);
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, RefusedRegisterByCongestionIsTriedAgainAfterTwait) {  // G16
    robot.subscribes("a/#");
    publishes("a/b", "1", Qos::at_least_once);
    const auto told = robot.hears<Register>();
    robot.says(Regack{told.topic_id, told.msg_id, ReturnCode::congestion});
    broker.waits(4min);
    robot.hears_nothing();
    broker.waits(1min);
    robot.hears_register("a/b");
    robot.hears_publish("1", Qos::at_least_once);
}

TEST_F(Delivering, CongestionHoldsUpTheMessagesOfItsTopicAlone) {  // G16
    robot.subscribes("a/#");
    publishes("a/b", "1", Qos::at_least_once);
    const auto told = robot.hears<Register>();
    publishes("a/b", "2", Qos::exactly_once);
    publishes("a/c", "3", Qos::exactly_once);
    publishes("a/b", "4", Qos::at_most_once);
    robot.says(Regack{told.topic_id, told.msg_id, ReturnCode::congestion});
    robot.hears_register("a/c");
    robot.hears_publish("3", Qos::exactly_once);
    publishes("a/c", "5", Qos::at_least_once);
    robot.hears_publish("5", Qos::at_least_once);
    publishes("a/c", "6", Qos::at_most_once);
    robot.hears_publish("6", Qos::at_most_once);
    robot.hears_nothing();
    broker.expects_mirror_to_agree();
    broker.waits(5min);
    robot.hears_register("a/b");
    robot.hears_publish("1", Qos::at_least_once);
    robot.hears_publish("2", Qos::exactly_once);
    robot.hears_publish("4", Qos::at_most_once);
    robot.hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, PublishAnsweredByCongestionIsSentAgainAfterTwaitAndNeverLost) {  // 6.13
    robot.subscribes("a");
    publishes("a", "1", Qos::at_least_once);
    publishes("a", "2", Qos::exactly_once);
    for (int time = 0; time < 10; ++time) {
        acknowledges(robot.hears<Publish>(), ReturnCode::congestion);
        broker.waits(4min);
        robot.hears_nothing();
        gives_a_sign_of_life();
        broker.waits(1min);
    }
    EXPECT_TRUE(robot.hears_publish("1", Qos::at_least_once).dup);
    robot.hears_publish("2", Qos::exactly_once);
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 0u);
    broker.expects_mirror_to_agree();
}

TEST_F(Delivering, CongestionOfAClientThatIsAskedForASignOfLifeIsHeededToo) {  // G5, 6.13
    robot.subscribes("a");
    publishes("a", "1", Qos::at_least_once);
    const auto publish = robot.hears<Publish>();
    broker.waits(10min);
    robot.ignores_what_came();
    acknowledges(publish, ReturnCode::congestion);
    broker.waits(4min);
    robot.hears_nothing();
    broker.waits(1min);
    robot.hears_publish("1", Qos::at_least_once);
    robot.hears_nothing();
}

TEST_F(Delivering, AMessageThatIsPassedOverAfterCongestionHasAllItsTimes) {  // G5, 6.13
    robot.subscribes("a");
    publishes("a", "too long", Qos::at_least_once);
    acknowledges(robot.hears<Publish>(), ReturnCode::congestion);
    gives_a_sign_of_life();
    broker.waits(5min);
    for (int sending = 0; sending < 4; ++sending) {
        EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 0u);
        EXPECT_EQ(as_text(robot.hears<Publish>().data), "too long");
        gives_a_sign_of_life();
        broker.waits(10s);
    }
    EXPECT_EQ(broker.dropped(Drop::retries_exhausted), 1u);
}

TEST_F(Delivering, WhatWaitsForCongestionToEndCountsInTheQueue) {  // P8, G16
    BrokerOptions options = logging_options();
    options.limits.queued_per_session = 4;
    options.limits.pacing_ms = 0;
    ScriptedBroker small{options};
    ScriptedClient from{small, "from"};
    ScriptedClient to{small, "to"};
    from.connects();
    to.connects();
    to.subscribes("a/#");
    const TopicId b = from.registers("a/b");
    const TopicId c = from.registers("a/c");
    for (int i = 0; i < 4; ++i) from.publishes(b, "b", Qos::at_least_once);
    const auto told = to.hears<Register>();
    to.says(Regack{told.topic_id, told.msg_id, ReturnCode::congestion});
    from.publishes(c, "c", Qos::at_least_once);
    EXPECT_EQ(small.dropped(Drop::queue_full), 1u);
    to.hears_nothing();
    small.expects_mirror_to_agree();
}

TEST_F(Delivering, TwoOctetNameUnderAWildcardGoesAsShortName) {  // G17
    robot.subscribes("#");
    publishes("ab", "x", Qos::at_most_once);
    const auto publish = robot.hears_publish("x");
    EXPECT_EQ(publish.topic_type, TopicIdType::short_name);
    EXPECT_EQ(publish.topic, TopicId{0x6162});
}

TEST_F(Delivering, FullQueueDropsTheOldestQos0First) {  // P8, G10
    BrokerOptions options = plain_options();
    options.limits.queued_per_session = 3;
    ScriptedBroker small{options};
    ScriptedClient from{small, "from"};
    ScriptedClient to{small, "to"};
    from.connects();
    to.connects();
    to.subscribes("a");
    to.says(Disconnect{true, 100});
    to.hears<Disconnect>();
    const TopicId id = from.registers("a");
    from.publishes(id, "0a", Qos::at_most_once);
    from.publishes(id, "1a", Qos::at_least_once);
    from.publishes(id, "0b", Qos::at_most_once);
    from.publishes(id, "1b", Qos::at_least_once);  // drops 0a
    from.publishes(id, "1c", Qos::at_least_once);  // drops 0b
    from.publishes(id, "1d", Qos::at_least_once);  // does not fit
    EXPECT_EQ(small.dropped(Drop::queue_full), 3u);
    to.says(Pingreq{"to"});
    to.hears_publish("1a", Qos::at_least_once);
    to.hears_publish("1b", Qos::at_least_once);
    to.hears_publish("1c", Qos::at_least_once);
    to.hears<Pingresp>();
}

TEST_F(Delivering, MsgIdsAreNeverZero) {  // 6.10d
    robot.subscribes("a", Qos::at_least_once);
    const TopicId id = publisher.registers("a");
    for (int i = 0; i < 65'540; ++i) {
        publisher.publishes(id, "x", Qos::at_least_once);
        const auto publish = robot.hears<Publish>();
        ASSERT_NE(publish.msg_id, no_msg_id);
        acknowledges(publish, ReturnCode::accepted);
    }
}

TEST_F(Delivering, Qos2PublishAndPubrelWaitForTheLog) {  // design: QoS 2 hand-shake
    robot.subscribes("a");
    publishes("a", "x", Qos::exactly_once);
    const MsgId msg_id = robot.hears<Publish>().msg_id;
    robot.says(Pubrec{msg_id});
    EXPECT_EQ(broker.last_after, broker.core.last_seq());
    EXPECT_TRUE(std::holds_alternative<DeliveryReleased>(broker.log.back()));
}

}  // namespace
}  // namespace romano::broker::delivery_flow_test
