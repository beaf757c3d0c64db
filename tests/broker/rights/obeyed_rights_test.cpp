// What a broker does with rights: refusals as MQTT-SN has them, counted, told in a line; and who
// takes sessions over obeys the same.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "broker/protection/protected_node.h"
#include "broker/rights/rights.h"
#include "tests/broker/core/scripted_client.h"

namespace romano::broker::obeyed_rights_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::string_view rules =
    "group robots\npattern readwrite robots/%i/#\ntopic read news/#\n"
    "group operators\ntopic readwrite #\ntopic deny secret/#\n"
    "topic read open/#\ntopic write QQ\n";  // of operators still

std::unique_ptr<rights::Rights> rights_by(std::string_view text) {
    return std::make_unique<rights::Rights>(
        *rights::parse(text),
        std::vector<rights::KeyOwner>{{"r1", rights::Role::robot}, {"anna", rights::Role::person}});
}

class ObeyedRights : public testing::Test {
protected:
    ObeyedRights() {
        broker.core.set_permissions(given.get());
        broker.via.packets = Endpoint::Packets::sealed;
        for (ScriptedClient* client : {&robot, &anna}) {
            client->via.packets = Endpoint::Packets::sealed;
            client->address.wireless_node_id = protected_node_id(client->id);
            client->connects();
        }
    }
    void give(std::string_view text) {
        auto next = rights_by(text);
        broker.core.set_permissions(next.get());
        given = std::move(next);
    }
    ReturnCode subscribes(ScriptedClient& client, std::string_view filter) {
        client.says(Subscribe{false,
                              Qos::at_least_once,
                              client.next_msg_id(),
                              {TopicIdType::normal, filter, no_topic_id}});
        return client.hears<Suback>().return_code;
    }
    [[nodiscard]] std::uint64_t refused(Refused what) const {
        return broker.core.counters().refused[static_cast<std::size_t>(what)];
    }

    std::unique_ptr<rights::Rights> given = rights_by(rules);
    ScriptedBroker broker{logging_options()};
    ScriptedClient robot{broker, "r1"};
    ScriptedClient anna{broker, "anna"};
};

TEST_F(ObeyedRights, RefuseATopicIdByRegack3) {
    robot.says(Register{no_topic_id, MsgId{5}, "robots/r2/pose"});
    const auto answer = robot.hears<Regack>();
    EXPECT_EQ(answer.return_code, ReturnCode::not_supported);
    EXPECT_EQ(answer.msg_id, MsgId{5});
    EXPECT_EQ(refused(Refused::register_), 1u);
    EXPECT_THAT(broker.notes, ElementsAre("refused: robot r1 may not register 'robots/r2/pose'"));
}

TEST_F(ObeyedRights, RefuseAPublishByPuback3AtEveryQosAndHandNothingOn) {
    anna.subscribes("news/#", Qos::at_most_once);
    const TopicId news = robot.subscribes("news/today");  // an id to read under
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
        robot.says(Publish{false, qos, true, TopicIdType::normal, news, MsgId{9}, as_octets("x")});
        const auto answer = robot.hears<Puback>();
        EXPECT_EQ(answer.return_code, ReturnCode::not_supported);
        EXPECT_EQ(answer.msg_id, MsgId{9});
    }
    anna.hears_nothing();
    EXPECT_THAT(broker.core.retained(), IsEmpty());
    EXPECT_EQ(refused(Refused::publish), 3u);
}

TEST_F(ObeyedRights, CountWhatComesWithoutAConnection) {
    anna.subscribes("#", Qos::at_most_once);
    robot.says(Publish{false, Qos::without_connection, false, TopicIdType::short_name,
                       TopicId{0x5151}, no_msg_id, as_octets("x")});
    robot.hears_nothing();
    anna.hears_nothing();
    EXPECT_EQ(refused(Refused::publish), 1u);
    ScriptedClient stranger{broker, ""};
    stranger.via.packets = Endpoint::Packets::plain;
    stranger.says(Publish{false, Qos::without_connection, false, TopicIdType::short_name,
                          TopicId{0x5151}, no_msg_id, as_octets("x")});
    EXPECT_EQ(refused(Refused::publish), 2u);
    anna.hears_nothing();
}

TEST_F(ObeyedRights, RefuseASubscriptionBySuback3OfWhichNothingMayBeRead) {
    EXPECT_EQ(subscribes(robot, "robots/r2/pose"), ReturnCode::not_supported);
    EXPECT_EQ(subscribes(robot, "robots/r2/#"), ReturnCode::not_supported);
    EXPECT_EQ(subscribes(anna, "secret/+"), ReturnCode::not_supported);
    EXPECT_EQ(subscribes(robot, "predefined"), ReturnCode::not_supported);
    EXPECT_EQ(refused(Refused::subscribe), 4u);
    EXPECT_EQ(subscribes(robot, "robots/+/pose"), ReturnCode::accepted);
    EXPECT_THAT(broker.core.image("r1")->subscriptions, SizeIs(1));
}

TEST_F(ObeyedRights, AWiderSubscriptionBringsWhatMayBeRead) {
    EXPECT_EQ(subscribes(robot, "#"), ReturnCode::accepted);
    const TopicId news = anna.registers("news/today");
    const TopicId other = anna.registers("robots/r2/pose");
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
        anna.publishes(other, "not for r1", qos);
    }
    EXPECT_EQ(refused(Refused::delivery), 3u);
    robot.hears_nothing();
    anna.publishes(news, "for all", Qos::at_least_once);
    const auto told = robot.hears<Register>();
    EXPECT_EQ(told.topic_name, "news/today");
    EXPECT_THAT(broker.notes, IsEmpty()) << "nobody did what it may not";
}

TEST_F(ObeyedRights, LetSomebodyPublishOnTheOneOpenTopicUnderDollar) {
    BrokerOptions options = logging_options();
    options.open_topic = rights::rights_topic;
    ScriptedBroker open{options};
    ScriptedClient setter{open, "anna"};
    open.via.packets = setter.via.packets = Endpoint::Packets::sealed;
    setter.address.wireless_node_id = protected_node_id(setter.id);
    setter.connects();
    const std::string text = "group operators\ntopic write $ROMANO/rights\n";
    const TopicId topic = setter.registers(std::string{rights::rights_topic});
    const auto publish = [&] {
        setter.says(Publish{false, Qos::at_least_once, true, TopicIdType::normal, topic,
                            setter.next_msg_id(), as_octets(text)});
        return setter.hears<Puback>().return_code;
    };
    EXPECT_EQ(publish(), ReturnCode::not_supported) << "where nobody is asked, nobody may";
    const auto asked = rights_by(text);
    open.core.set_permissions(asked.get());
    EXPECT_EQ(publish(), ReturnCode::accepted);
    ASSERT_THAT(open.core.retained(rights::rights_topic), SizeIs(1));
    open.core.set_permissions(nullptr);
}

TEST_F(ObeyedRights, HoldForRetainedMessages) {
    anna.publishes(anna.registers("robots/r2/pose"), "not for r1", Qos::at_least_once, true);
    anna.publishes(anna.registers("robots/r1/goal"), "for r1", Qos::at_least_once, true);
    EXPECT_EQ(subscribes(robot, "robots/#"), ReturnCode::accepted);
    EXPECT_EQ(robot.hears<Register>().topic_name, "robots/r1/goal");
    EXPECT_THAT(broker.core.image("r1")->deliveries, SizeIs(1));
}

TEST_F(ObeyedRights, HoldForWhatTheBrokerSaysOfItself) {
    EXPECT_EQ(subscribes(robot, "$SYS/#"), ReturnCode::not_supported);
    give(std::string{rules} + "group robots\ntopic read $SYS/brokers/#\n");
    EXPECT_EQ(subscribes(robot, "$SYS/#"), ReturnCode::accepted);
    broker.core.set_system_topic(broker.now, "$SYS/other", as_octets("x"), broker.actions);
    broker.drain();
    robot.hears_nothing();
    broker.core.set_system_topic(broker.now, "$SYS/brokers/b1", as_octets("x"), broker.actions);
    broker.drain();
    EXPECT_EQ(robot.hears<Register>().topic_name, "$SYS/brokers/b1");
}

TEST_F(ObeyedRights, AWillIsRefusedWhenItIsMadeAndWhenItIsToBeSaid) {
    robot.says(robot.connect(true, 10, true));
    robot.hears<Willtopicreq>();
    robot.says(Willtopic{Qos::at_least_once, false, "robots/r2/will"});
    robot.hears<Willmsgreq>();
    robot.says(Willmsg{as_octets("gone")});
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::not_supported);
    EXPECT_EQ(refused(Refused::will), 1u);

    robot.says(robot.connect(true, 10, true));
    robot.hears<Willtopicreq>();
    robot.says(Willtopic{Qos::at_least_once, false, "robots/r1/will"});
    robot.hears<Willmsgreq>();
    robot.says(Willmsg{as_octets("gone")});
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::accepted);
    robot.says(Willtopicupd{Qos::at_least_once, false, "robots/r2/will"});
    EXPECT_EQ(robot.hears<Willtopicresp>().return_code, ReturnCode::not_supported);
    anna.subscribes("robots/#", Qos::at_most_once);
    give("group operators\ntopic readwrite #\n");
    broker.waits(60s);
    EXPECT_EQ(broker.core.header("r1")->state, SessionState::lost);
    EXPECT_EQ(refused(Refused::will), 3u);
    anna.hears_nothing();
    broker.expects_mirror_to_agree();
}

TEST_F(ObeyedRights, HoldForTheUplink) {
    give("group operators\ntopic readwrite #\ngroup uplink\ntopic write in/#\n");
    anna.subscribes("#", Qos::at_most_once);
    const auto comes_in = [&](std::string_view topic) {
        broker.core.publish(broker.now, topic, as_octets("x"), Qos::at_most_once, false,
                            broker.actions, "elsewhere/1");
        broker.actions.clear();  // the owner's
    };
    comes_in("out/a");
    EXPECT_EQ(refused(Refused::publish), 1u);
    comes_in("in/a");
    EXPECT_EQ(refused(Refused::publish), 1u);
}

TEST_F(ObeyedRights, ChangedOnesHoldAtOnceForSubscriptionsAndWhatWaits) {
    const TopicId news = anna.registers("news/today");
    robot.subscribes("news/#", Qos::at_least_once);
    anna.publishes(news, "first", Qos::at_least_once);
    anna.publishes(news, "second", Qos::at_least_once);
    const auto told = robot.hears<Register>();  // both wait for the answer
    give("group operators\ntopic readwrite #\n");
    robot.says(Regack{told.topic_id, told.msg_id, ReturnCode::accepted});
    robot.hears_nothing();
    anna.publishes(news, "third", Qos::at_least_once);
    robot.hears_nothing();
    EXPECT_EQ(refused(Refused::delivery), 3u);
    EXPECT_THAT(broker.core.image("r1")->deliveries, IsEmpty());
    give(rules);
    anna.publishes(news, "fourth", Qos::at_least_once);
    robot.hears_publish("fourth", Qos::at_least_once);
    broker.expects_mirror_to_agree();
}

TEST_F(ObeyedRights, AnHeirAppliesTheSameToTheSessionsThatItTakesOver) {
    robot.subscribes("#", Qos::at_most_once);
    const TopicId own = robot.registers("robots/r1/pose");
    ScriptedBroker heir{logging_options()};
    heir.via.packets = Endpoint::Packets::sealed;
    heir.core.set_permissions(given.get());
    heir.core.adopt(heir.now, *broker.core.image("r1"), {}, heir.actions);
    heir.drain();
    robot.moves_to(heir);
    robot.publishes(own, "x", Qos::at_least_once);
    robot.hears<Publish>();
    robot.says(Register{no_topic_id, robot.next_msg_id(), "robots/r2/pose"});
    EXPECT_EQ(robot.hears<Regack>().return_code, ReturnCode::not_supported);
    const auto told = [&](const char* topic) {
        const broker::Message message{.topic = topic,
                                      .payload = octets_of("x"),
                                      .qos = Qos::at_most_once,
                                      .retain = false,
                                      .position = {{broker_id_of("b2"), 1}, 0},
                                      .published_at = {}};
        heir.core.on_peer_message(heir.now, MessagePtr{message}, heir.actions);
        heir.drain();
    };
    told("robots/r2/pose");
    robot.hears_nothing();
    told("news/today");
    EXPECT_EQ(robot.hears<Register>().topic_name, "news/today");
}

/// A session keeps its subscriptions when another one speaks for it: with that one's rights.
TEST_F(ObeyedRights, ASubscriptionIsReadWithTheRightsOfWhoSpeaksNow) {
    give("group plain\ntopic readwrite #\n" + std::string{rules});
    ScriptedClient r2{broker, "r2"};
    r2.via.packets = Endpoint::Packets::plain;
    r2.says(r2.connect(false));
    EXPECT_EQ(r2.hears<Connack>().return_code, ReturnCode::accepted);
    r2.subscribes("#", Qos::at_most_once);
    r2.via.packets = Endpoint::Packets::sealed;
    r2.address.wireless_node_id = protected_node_id("r2");  // which has no key
    r2.says(r2.connect(false));
    EXPECT_EQ(r2.hears<Connack>().return_code, ReturnCode::accepted);
    anna.publishes(anna.registers("news/today"), "x");
    r2.hears_nothing();
}

TEST_F(ObeyedRights, RefusalsAreToldInALineASecondAtMostWithTheirNumber) {
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(subscribes(robot, "robots/r2/\x1b[2J"), ReturnCode::not_supported);
    }
    EXPECT_THAT(broker.notes,
                ElementsAre("refused: robot r1 may not subscribe to 'robots/r2/?[2J'"));
    broker.waits(2s);
    EXPECT_EQ(subscribes(robot, "robots/r2/pose"), ReturnCode::not_supported);
    ASSERT_THAT(broker.notes, SizeIs(2));
    EXPECT_THAT(broker.notes[1], HasSubstr("'robots/r2/pose'; 4 more since the last such line"));
}

}  // namespace
}  // namespace romano::broker::obeyed_rights_test
