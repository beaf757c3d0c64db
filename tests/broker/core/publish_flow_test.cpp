// PUBLISH from clients: MQTT-SN 1.2 sections 6.6, 6.8 and the choices G19, G22, G23; retained
// messages.

#include <gtest/gtest.h>

#include <string>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::publish_flow_test {
namespace {

class Publishing : public ::testing::Test {
protected:
    Publishing() {
        robot.connects();
        watcher.connects();
    }

    ScriptedBroker broker{logging_options()};
    ScriptedClient robot{broker, "robot"};
    ScriptedClient watcher{broker, "watcher"};
};

TEST_F(Publishing, UnknownIdIsAnsweredAtEveryQosWithTopicIdAndMsgIdCopied) {  // 6.6b, G22
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
        robot.says(Publish{false, qos, false, TopicIdType::normal, TopicId{77}, MsgId{9}, {}});
        const auto answer = robot.hears<Puback>();
        EXPECT_EQ(answer.return_code, ReturnCode::invalid_topic_id);
        EXPECT_EQ(answer.topic_id, TopicId{77});
        EXPECT_EQ(answer.msg_id, MsgId{9});
    }
    EXPECT_EQ(broker.dropped(Drop::invalid_topic), 3u);
}

TEST_F(Publishing, ReservedIdsAreNeverAccepted) {  // 5.3.11a
    for (const TopicId id : {no_topic_id, reserved_topic_id}) {
        robot.says(
            Publish{false, Qos::at_least_once, false, TopicIdType::normal, id, MsgId{1}, {}});
        EXPECT_EQ(robot.hears<Puback>().return_code, ReturnCode::invalid_topic_id);
    }
}

TEST_F(Publishing, IdOfOneClientMeansNothingForAnother) {  // 7.3a
    const TopicId id = robot.registers("a");
    watcher.says(Publish{false, Qos::at_least_once, false, TopicIdType::normal, id, MsgId{1}, {}});
    EXPECT_EQ(watcher.hears<Puback>().return_code, ReturnCode::invalid_topic_id);
}

TEST_F(Publishing, RepeatedQos2IsHandedOnOnce) {  // 6.6d
    watcher.subscribes("a", Qos::at_most_once);
    const TopicId id = robot.registers("a");
    Publish publish{false, Qos::exactly_once, false,         TopicIdType::normal,
                    id,    MsgId{4},          as_octets("x")};
    robot.says(publish);
    EXPECT_EQ(robot.hears<Pubrec>().msg_id, MsgId{4});
    publish.dup = true;
    robot.says(publish);
    EXPECT_EQ(robot.hears<Pubrec>().msg_id, MsgId{4});
    publish.dup = false;  // emcute repeats with DUP 0: a hint, never a reason
    robot.says(publish);
    EXPECT_EQ(robot.hears<Pubrec>().msg_id, MsgId{4});
    watcher.hears_publish("x");
    watcher.hears_nothing();
    robot.says(Pubrel{MsgId{4}});
    EXPECT_EQ(robot.hears<Pubcomp>().msg_id, MsgId{4});
    robot.says(publish);  // the msg id is free again
    robot.hears<Pubrec>();
    watcher.hears_publish("x");
    broker.expects_mirror_to_agree();
}

TEST_F(Publishing, PubrelOfAnUnknownMsgIdGetsPubcomp) {  // 6.6d
    robot.says(Pubrel{MsgId{99}});
    EXPECT_EQ(robot.hears<Pubcomp>().msg_id, MsgId{99});
}

TEST_F(Publishing, AbandonedQos2ExchangesAreBounded) {  // P8
    const TopicId id = robot.registers("a");
    for (std::uint16_t msg_id = 1; msg_id <= 100; ++msg_id) {
        robot.says(
            Publish{false, Qos::exactly_once, false, TopicIdType::normal, id, MsgId{msg_id}, {}});
        robot.hears<Pubrec>();
    }
    EXPECT_EQ(broker.core.image("robot")->unreleased.size(), 64u);
    broker.expects_mirror_to_agree();
}

TEST_F(Publishing, MsgIdZeroAndMsgIdAtQos0AreTaken) {  // G23
    watcher.subscribes("a");
    const TopicId id = robot.registers("a");
    robot.says(Publish{false, Qos::at_least_once, false, TopicIdType::normal, id, no_msg_id,
                       as_octets("1")});
    EXPECT_EQ(robot.hears<Puback>().msg_id, no_msg_id);
    watcher.hears_publish("1", Qos::at_least_once);
    robot.says(Publish{false, Qos::at_most_once, false, TopicIdType::normal, id, MsgId{8},
                       as_octets("0")});
    robot.hears_nothing();
    watcher.hears_publish("0");
}

TEST_F(Publishing, PredefinedAndShortTopicsNeedNoRegistration) {  // 6.7
    watcher.subscribes("predefined/seven");
    watcher.subscribes("ab");
    robot.says(Publish{false, Qos::at_least_once, false, TopicIdType::predefined, TopicId{7},
                       MsgId{1}, as_octets("p")});
    EXPECT_EQ(robot.hears<Puback>().return_code, ReturnCode::accepted);
    watcher.hears_publish("p", Qos::at_least_once);
    robot.says(Publish{false, Qos::at_most_once, false, TopicIdType::short_name, TopicId{0x6162},
                       no_msg_id, as_octets("s")});
    watcher.hears_publish("s");
    robot.says(Publish{false, Qos::at_most_once, false, TopicIdType::predefined, TopicId{8},
                       no_msg_id, as_octets("p")});
    EXPECT_EQ(robot.hears<Puback>().return_code, ReturnCode::invalid_topic_id);
}

TEST_F(Publishing, ShortNameMustBeAValidName) {  // G26
    robot.says(Publish{false,
                       Qos::at_least_once,
                       false,
                       TopicIdType::short_name,
                       TopicId{0x612B},  // "a+"
                       MsgId{1},
                       {}});
    EXPECT_EQ(robot.hears<Puback>().return_code, ReturnCode::not_supported);
}

TEST_F(Publishing, ConnectionlessPublishIsTakenFromAnybodyAndNeverAnswered) {  // 6.8a
    watcher.subscribes("ab");
    ScriptedClient stranger{broker, "stranger"};
    const auto qos_minus_1 = [](TopicIdType type, std::uint16_t topic, std::string_view data) {
        return Publish{false,     Qos::without_connection, false, type, TopicId{topic},
                       no_msg_id, as_octets(data)};
    };
    stranger.says(qos_minus_1(TopicIdType::short_name, 0x6162, "x"));
    watcher.hears_publish("x");
    stranger.says(qos_minus_1(TopicIdType::predefined, 999, "x"));
    stranger.says(qos_minus_1(TopicIdType::normal, 0, "x"));
    stranger.says(qos_minus_1(TopicIdType::normal, 200, "x"));
    stranger.hears_nothing();
    watcher.hears_nothing();
    EXPECT_EQ(broker.dropped(Drop::invalid_topic), 3u);
}

TEST_F(Publishing, ConnectionlessPublishMaySpellTheNameBeforeTheData) {  // G19
    watcher.subscribes("long/name");
    ScriptedClient stranger{broker, "stranger"};
    stranger.says(Publish{false, Qos::without_connection, false, TopicIdType::normal, TopicId{9},
                          no_msg_id, as_octets("long/namedata")});
    watcher.hears_publish("data");
}

TEST_F(Publishing, TooLargePayloadIsRefused) {
    BrokerOptions options = plain_options();
    options.limits.payload_octets = 10;
    ScriptedBroker small{options};
    ScriptedClient client{small, "client"};
    client.connects();
    const TopicId id = client.registers("a");
    client.says(Publish{false, Qos::at_least_once, false, TopicIdType::normal, id, MsgId{1},
                        as_octets("01234567890")});
    EXPECT_EQ(client.hears<Puback>().return_code, ReturnCode::not_supported);
    EXPECT_EQ(small.dropped(Drop::too_large), 1u);
}

TEST_F(Publishing, LargePayloadCrossesInTheLongForm) {  // 5.2.1c
    watcher.subscribes("a");
    const std::string payload(65'000, 'x');
    robot.publishes(robot.registers("a"), payload, Qos::at_least_once);
    watcher.hears_publish(payload, Qos::at_least_once);
}

TEST_F(Publishing, BrokersOwnTopicsAreNotForClients) {
    robot.says(Register{no_topic_id, MsgId{1}, "$SYS/brokers/x"});
    const TopicId id = robot.hears<Regack>().topic_id;
    robot.says(Publish{false, Qos::at_least_once, true, TopicIdType::normal, id, MsgId{2}, {}});
    EXPECT_EQ(robot.hears<Puback>().return_code, ReturnCode::not_supported);
}

TEST_F(Publishing, Qos0IsForwardedToPeersAndNotLogged) {
    const TopicId id = robot.registers("a");
    const std::size_t events = broker.log.size();
    robot.publishes(id, "x");
    EXPECT_EQ(broker.log.size(), events);
    ASSERT_EQ(broker.forwards.size(), 1u);
    EXPECT_EQ(broker.forwards[0]->topic, "a");
    EXPECT_EQ(broker.forwards[0]->position.seq, 0u);
}

TEST_F(Publishing, Qos0ThatNoPeerWantsIsNotEvenBuiltForThem) {
    struct Picky final : Audience {
        [[nodiscard]] bool wants(std::string_view topic) const override { return topic == "a"; }
        [[nodiscard]] bool share_address_with(const SessionHeader&) const override { return false; }
        [[nodiscard]] std::size_t longest_queue(std::string_view, Instant) const override {
            return 0;
        }
    } peers;
    broker.core.set_audience(peers);
    robot.publishes(robot.registers("b"), "x");
    EXPECT_TRUE(broker.forwards.empty());
    robot.publishes(robot.registers("a"), "x");
    ASSERT_EQ(broker.forwards.size(), 1u);
    robot.publishes(robot.registers("b"), "x", Qos::at_least_once);  // the log is for all
    EXPECT_EQ(std::get<Published>(broker.log.back()).message->topic, "b");
}

TEST_F(Publishing, AnswerWaitsForTheEventOfTheMessage) {
    const TopicId id = robot.registers("a");
    robot.publishes(id, "x", Qos::at_least_once);
    EXPECT_TRUE(std::holds_alternative<Published>(broker.log.back()));
    EXPECT_EQ(broker.last_after, broker.log.size());
}

TEST_F(Publishing, EmptyRetainedPayloadDeletesAndIsDeliveredLive) {  // 1.6, M-3.3.1-10
    const TopicId id = robot.registers("map");
    robot.publishes(id, "grid", Qos::at_least_once, true);
    watcher.subscribes("map");
    EXPECT_TRUE(watcher.hears_publish("grid", Qos::at_least_once).retain);
    robot.publishes(id, "", Qos::at_least_once, true);
    EXPECT_FALSE(watcher.hears_publish("", Qos::at_least_once).retain);
    ScriptedClient late{broker, "late"};
    late.connects();
    late.subscribes("map");
    late.hears_nothing();
}

TEST_F(Publishing, RetainedMatchesOfAWildcardAreRegisteredOneByOne) {  // 4.11
    robot.publishes(robot.registers("map/1"), "a", Qos::at_least_once, true);
    robot.publishes(robot.registers("map/2"), "b", Qos::at_most_once, true);
    robot.publishes(robot.registers("other"), "c", Qos::at_most_once, true);
    watcher.subscribes("map/#");
    for (const auto& [name, data, qos] :
         {std::tuple{"map/1", "a", Qos::at_least_once}, {"map/2", "b", Qos::at_most_once}}) {
        watcher.hears_register(name);
        EXPECT_TRUE(watcher.hears_publish(data, qos).retain);
    }
    watcher.hears_nothing();
    broker.expects_mirror_to_agree();
}

/// Retains `count` messages under "map/…", from "0".
void retain_maps(ScriptedClient& robot, std::size_t count) {
    for (std::size_t n = 0; n < count; ++n) {
        robot.publishes(robot.registers("map/" + std::to_string(n)), std::to_string(n),
                        n % 2 == 0 ? Qos::at_most_once : Qos::at_least_once, true);
    }
}

/// Hears REGISTER and PUBLISH of one retained map.
std::string hear_a_map(ScriptedClient& watcher) {
    const auto told = watcher.hears<Register>();
    watcher.says(Regack{told.topic_id, told.msg_id, ReturnCode::accepted});
    const auto publish = watcher.hears<Publish>();
    EXPECT_TRUE(publish.retain);
    std::string data{as_text(publish.data)};
    if (publish.qos == Qos::at_least_once) {
        watcher.says(Puback{publish.topic, publish.msg_id, ReturnCode::accepted});
    }
    return data;
}

class PublishingWithShortQueues : public testing::Test {
protected:
    static BrokerOptions short_queues() {
        BrokerOptions options = logging_options();
        options.limits.queued_per_session = 4;
        return options;
    }
    void SetUp() override {
        robot.connects();
        watcher.connects();
    }
    ScriptedBroker broker{short_queues()};
    ScriptedClient robot{broker, "robot"};
    ScriptedClient watcher{broker, "watcher"};
};

TEST_F(PublishingWithShortQueues, MoreRetainedMessagesThanTheQueueHoldsComeAllTheSame) {
    retain_maps(robot, 9);
    watcher.subscribes("map/+");
    for (int n = 0; n < 9; ++n) EXPECT_EQ(hear_a_map(watcher), std::to_string(n));
    watcher.hears_nothing();
    EXPECT_EQ(broker.dropped(Drop::queue_full), 0u);
    broker.expects_mirror_to_agree();
}

TEST_F(PublishingWithShortQueues, LiveMessagesFindRoomWhileRetainedOnesAreStillToCome) {
    retain_maps(robot, 9);
    watcher.subscribes("map/+");
    const TopicId live = robot.registers("map/live");
    robot.publishes(live, "live", Qos::at_least_once);
    EXPECT_EQ(broker.dropped(Drop::queue_full), 0u);
}

TEST_F(PublishingWithShortQueues, RetainedMessagesThatAreStillToComeEndWithTheSubscription) {
    retain_maps(robot, 9);
    watcher.subscribes("map/+");
    watcher.says(Unsubscribe{watcher.next_msg_id(), {TopicIdType::normal, "map/+", no_topic_id}});
    const auto told = watcher.hears<Register>();
    watcher.hears<Unsuback>();
    watcher.says(Regack{told.topic_id, told.msg_id, ReturnCode::accepted});
    EXPECT_EQ(as_text(watcher.hears<Publish>().data), "0");
    EXPECT_EQ(hear_a_map(watcher), "1") << "two were in the queue";
    watcher.hears_nothing();
}

TEST_F(PublishingWithShortQueues, SubscribingAgainBeginsTheRetainedOnesAnew) {
    retain_maps(robot, 5);
    watcher.subscribes("map/+");
    watcher.ignores_what_came();
    watcher.connects();
    watcher.subscribes("map/+");
    for (int n = 0; n < 5; ++n) EXPECT_EQ(hear_a_map(watcher), std::to_string(n));
    watcher.hears_nothing();
}

/// Fills the watcher's queue, which answers nothing, up to `waiting` messages.
void fill(ScriptedClient& robot, TopicId topic, int waiting) {
    for (int n = 0; n < waiting; ++n) robot.publishes(topic, "x", Qos::at_least_once);
}

Publish qos1(TopicId topic, MsgId msg_id) {
    return {false, Qos::at_least_once, false, TopicIdType::normal, topic, msg_id, as_octets("x")};
}

TEST_F(PublishingWithShortQueues, AboveHalfAFullQueueOfItsReceiverThePublishersAnswerComesLater) {
    watcher.subscribes("pose", Qos::at_least_once);
    const TopicId pose = robot.registers("pose");
    fill(robot, pose, 3);  // the third finds two there: half
    robot.says(qos1(pose, MsgId{90}));
    robot.hears_nothing();
    broker.waits(499ms);
    robot.hears_nothing();
    broker.waits(1ms);  // three of four: half of the longest delay
    EXPECT_EQ(robot.hears<Puback>().msg_id, MsgId{90});
    EXPECT_EQ(broker.core.counters().late_answers, 1u);
    for (int n = 0; n < 4; ++n) watcher.hears_publish("x", Qos::at_least_once);
    fill(robot, pose, 1);  // and at once when there is room again
    broker.expects_mirror_to_agree();
}

TEST_F(PublishingWithShortQueues, AtQos2PubrecComesLater) {
    watcher.subscribes("pose", Qos::at_least_once);
    const TopicId pose = robot.registers("pose");
    fill(robot, pose, 3);
    Publish publish = qos1(pose, MsgId{90});
    publish.qos = Qos::exactly_once;
    robot.says(publish);
    robot.hears_nothing();
    broker.waits(500ms);
    EXPECT_EQ(robot.hears<Pubrec>().msg_id, MsgId{90});
    robot.says(Pubrel{MsgId{90}});
    robot.hears<Pubcomp>();
}

TEST_F(PublishingWithShortQueues, ARepetitionBeforeTheLateAnswerIsHandedOnOnceAndAnsweredOnce) {
    watcher.subscribes("pose", Qos::at_least_once);
    const TopicId pose = robot.registers("pose");
    fill(robot, pose, 3);
    robot.says(qos1(pose, MsgId{90}));
    robot.says(qos1(pose, MsgId{90}));
    broker.waits(500ms);
    robot.hears<Puback>();
    robot.hears_nothing();
    for (int n = 0; n < 4; ++n) watcher.hears_publish("x", Qos::at_least_once);
    watcher.hears_nothing();
}

// Roaming, it would never hear the answer of any of its homes.
TEST_F(PublishingWithShortQueues, ARepetitionOfWhatIsOwedSomewhereElseIsAnsweredAtOnce) {
    watcher.subscribes("pose", Qos::at_least_once);
    const TopicId pose = robot.registers("pose");
    fill(robot, pose, 3);
    Publish publish = qos1(pose, MsgId{90});
    publish.dup = true;
    robot.says(publish);
    EXPECT_EQ(robot.hears<Puback>().msg_id, MsgId{90});
}

TEST_F(PublishingWithShortQueues, APublisherThatDoesNotWaitGetsItsEarlierAnswerAtOnce) {
    watcher.subscribes("pose", Qos::at_least_once);
    const TopicId pose = robot.registers("pose");
    fill(robot, pose, 3);
    robot.says(qos1(pose, MsgId{90}));
    robot.says(qos1(pose, MsgId{91}));
    EXPECT_EQ(robot.hears<Puback>().msg_id, MsgId{90});
    EXPECT_EQ(broker.dropped(Drop::queue_full), 1u);
    broker.waits(999ms);
    robot.hears_nothing();
    broker.waits(1ms);  // there is no room at all: the longest delay
    EXPECT_EQ(robot.hears<Puback>().msg_id, MsgId{91});
}

TEST_F(PublishingWithShortQueues, AReceiverThatDoesNotAnswerHoldsUpNobodyAndLosesWhatIsTooMuch) {
    watcher.subscribes("pose", Qos::at_least_once);
    const TopicId pose = robot.registers("pose");
    fill(robot, pose, 3);
    broker.waits(plain_options().t_retry + 1ms);  // its message was sent again
    fill(robot, pose, 3);
    EXPECT_EQ(broker.dropped(Drop::queue_full), 2u);
}

TEST_F(PublishingWithShortQueues, ASleeperHoldsUpNobody) {
    watcher.subscribes("pose", Qos::at_least_once);
    watcher.says(Disconnect{true, 60});
    const TopicId pose = robot.registers("pose");
    fill(robot, pose, 6);
    EXPECT_EQ(broker.dropped(Drop::queue_full), 2u);
}

TEST_F(PublishingWithShortQueues, AReceiverAtAPeerHoldsUpItsPublishersAlike) {
    struct Peers final : Audience {
        [[nodiscard]] bool wants(std::string_view) const override { return true; }
        [[nodiscard]] bool share_address_with(const SessionHeader&) const override { return false; }
        [[nodiscard]] std::size_t longest_queue(std::string_view topic,
                                                Instant since) const override {
            return topic == "pose" && taken_at > since ? 3 : 0;
        }
        Instant taken_at;
    } peers;
    peers.taken_at = broker.now;
    broker.core.set_audience(peers);
    const TopicId pose = robot.registers("pose");
    robot.publishes(robot.registers("map"), "x", Qos::at_least_once);
    robot.says(qos1(pose, MsgId{90}));
    robot.hears_nothing();
    broker.waits(500ms);  // three of four: half of the longest delay
    EXPECT_EQ(robot.hears<Puback>().msg_id, MsgId{90});
    broker.waits(plain_options().t_retry);
    fill(robot, pose, 1);  // it does not answer any more
}

TEST_F(PublishingWithShortQueues, APublishersOwnQueueDoesNotHoldItUp) {
    robot.subscribes("pose", Qos::at_least_once);
    const TopicId pose = robot.registers("pose");
    robot.says(qos1(pose, MsgId{90}));
    EXPECT_EQ(robot.hears<Puback>().msg_id, MsgId{90});
    robot.hears<Publish>();
    for (std::uint16_t id = 91; id < 95; ++id) {
        robot.says(qos1(pose, MsgId{id}));
        EXPECT_EQ(robot.hears<Puback>().msg_id, MsgId{id});
    }
}

TEST_F(PublishingWithShortQueues, AnAnswerThatIsOwedIsForgottenWithItsSession) {
    watcher.subscribes("pose", Qos::at_least_once);
    const TopicId pose = robot.registers("pose");
    fill(robot, pose, 3);
    robot.says(qos1(pose, MsgId{90}));
    robot.connects();
    broker.waits(1s);
    robot.hears_nothing();
}

TEST_F(PublishingWithShortQueues, AnAnswerThatIsOwedIsForgottenWhenItsSessionIsResumed) {
    watcher.subscribes("pose", Qos::at_least_once);
    ScriptedClient keeper{broker, "keeper"};
    keeper.connects(false);
    const TopicId pose = keeper.registers("pose");
    fill(robot, robot.registers("pose"), 3);
    keeper.says(qos1(pose, MsgId{1}));
    keeper.connects(false);  // it has begun anew, and counts its msg ids from 1
    for (int n = 0; n < 4; ++n) watcher.hears_publish("x", Qos::at_least_once);
    Publish publish = qos1(pose, MsgId{1});
    publish.data = as_octets("new");
    keeper.says(publish);
    watcher.hears_publish("new", Qos::at_least_once);
    EXPECT_EQ(keeper.hears<Puback>().msg_id, MsgId{1});
    broker.waits(1s);
    keeper.hears_nothing();
}

TEST_F(Publishing, SubscribingAgainSendsTheRetainedMessageAgain) {  // 6.9f, M-3.8.4-3
    robot.publishes(robot.registers("map"), "grid", Qos::at_most_once, true);
    for (int i = 0; i < 2; ++i) {
        watcher.subscribes("map");
        EXPECT_TRUE(watcher.hears_publish("grid").retain);
    }
}

TEST_F(Publishing, LaterRetainedMessageOfAPeerWins) {  // design: P6
    robot.publishes(robot.registers("map"), "ours", Qos::at_least_once, true);
    const auto of_peer = [](std::string_view data, std::uint64_t time) {
        return MessagePtr{Message{.topic = "map",
                                  .payload = octets_of(data),
                                  .qos = Qos::at_least_once,
                                  .retain = true,
                                  .position = {{broker_id_of("peer"), 1}, 1},
                                  .published_at = {time}}};
    };
    broker.core.put_retained(of_peer("older", 1));
    EXPECT_EQ(as_text(broker.core.retained().at(0)->payload), "ours");
    broker.core.put_retained(of_peer("later", std::uint64_t{1} << 60U));
    EXPECT_EQ(as_text(broker.core.retained().at(0)->payload), "later");
    EXPECT_EQ(as_text(broker.core.retained_at({{broker_id_of("peer"), 1}, 1})->payload), "later");
    robot.publishes(robot.registers("map"), "ours again", Qos::at_least_once, true);
    EXPECT_EQ(as_text(broker.core.retained().at(0)->payload), "ours again");
}

TEST_F(Publishing, SystemTopicsAreRetainedButNeitherLoggedNorForwarded) {
    watcher.subscribes("$SYS/brokers/b1");
    const std::size_t events = broker.log.size();
    broker.core.set_system_topic(broker.now, "$SYS/brokers/b1", as_octets("{}"), broker.actions);
    broker.drain();
    watcher.hears_publish("{}");
    watcher.subscribes("$SYS/brokers/b1");
    EXPECT_TRUE(watcher.hears_publish("{}").retain);
    EXPECT_EQ(broker.log.size(), events + 1);  // the subscription
    EXPECT_TRUE(broker.forwards.empty());
    EXPECT_TRUE(broker.core.retained().empty());
}

}  // namespace
}  // namespace romano::broker::publish_flow_test
