// Every table has a bound and a stated behaviour beyond it (promise P8); what is there can be
// counted. Sessions, queues, topics and subscriptions that are full: see their procedures' tests.

#include "broker/core/limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::limits_test {
namespace {

template <typename Number>
BrokerOptions options_with(Number Limits::*limit, Number value) {
    BrokerOptions options = plain_options();
    options.limits.*limit = value;
    return options;
}

TEST(Limit, OfClientsAmidWillPromptsIsAnsweredByCongestion) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::connecting, 1)};
    ScriptedClient first{broker, "first"};
    ScriptedClient second{broker, "second"};
    first.says(first.connect(true, 0, true));
    first.hears<Willtopicreq>();
    second.says(second.connect(true, 0, true));
    EXPECT_EQ(second.hears<Connack>().return_code, ReturnCode::congestion);
    EXPECT_EQ(broker.dropped(Drop::no_room), 1u);
    first.says(Willtopic{});
    EXPECT_EQ(first.hears<Connack>().return_code, ReturnCode::accepted);
    second.says(second.connect(true, 0, true));
    second.hears<Willtopicreq>();
}

TEST(Limit, OfSessionsIsNotUsedUpByOneAddressThatConnectsUnderNameAfterName) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::sessions, 3)};
    ScriptedClient watcher{broker, "watcher"};
    watcher.connects();
    watcher.subscribes("will", Qos::at_most_once);
    for (const std::string name : {"a", "b", "c", "d", "e"}) {
        ScriptedClient another{broker, name, 7000};
        another.connects(true, 0);  // keep-alive 0: never lost by its silence
        another.says(Willtopicupd{Qos::at_most_once, false, "will"});
        another.hears<Willtopicresp>();
        another.says(Willmsgupd{as_octets(name)});
        another.hears<Willmsgresp>();
    }
    // There is room for two of them. Whose address has another owner is lost when room is needed,
    // the one that lost it first first; and its will is said.
    for (const std::string name : {"a", "b", "c"}) watcher.hears_publish(name);
    watcher.hears_nothing();
    EXPECT_THAT(broker.core.client_ids(), testing::UnorderedElementsAre("d", "e", "watcher"));
}

TEST(Limit, OfSessionsIsNotMadeRoomForByKeptOnes) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::sessions, 2)};
    ScriptedClient kept{broker, "kept", 7000};
    kept.connects(false);
    ScriptedClient another{broker, "another", 7000};
    another.connects();  // the kept session has lost its address
    ScriptedClient late{broker, "late"};
    late.says(late.connect());
    EXPECT_EQ(late.hears<Connack>().return_code, ReturnCode::congestion);
}

TEST(Limit, OfSessionsIsNotMadeRoomForByOneThatIsBackAtAnAddress) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::sessions, 2)};
    ScriptedClient robot{broker, "robot", 7000};
    robot.connects();
    ScriptedClient another{broker, "another", 7000};
    another.connects();
    robot.address.endpoint.port = 7001;
    robot.connects();
    ScriptedClient late{broker, "late"};
    late.says(late.connect());
    EXPECT_EQ(late.hears<Connack>().return_code, ReturnCode::congestion);
}

/// Client `name` of a machine, at a port of its own, leaves a kept session behind.
void leaves_kept_session(ScriptedBroker& broker, const std::string& name, std::uint8_t machine) {
    ScriptedClient client{broker, name};
    client.address.endpoint.address[3] = machine;
    client.connects(false);
    client.says(Disconnect{});
    client.hears<Disconnect>();
    broker.waits(1s);
}

TEST(Limit, OfKeptSessionsOfAnIpAddressForgetsTheOneThatIsAwayForLongest) {
    BrokerOptions options = logging_options();
    options.limits.kept_per_address = 2;
    ScriptedBroker broker{options};
    leaves_kept_session(broker, "another's", 9);
    for (const std::string name : {"a", "b", "c"}) leaves_kept_session(broker, name, 8);
    EXPECT_THAT(broker.core.client_ids(), testing::UnorderedElementsAre("another's", "b", "c"));
    EXPECT_EQ(broker.core.counters().sessions_forgotten, 1u);
    ScriptedClient back{broker, "b"};
    back.address.endpoint.address[3] = 8;
    back.connects(false);  // it is not away any more
    leaves_kept_session(broker, "d", 8);
    EXPECT_THAT(broker.core.client_ids(),
                testing::UnorderedElementsAre("another's", "b", "c", "d"));
    broker.expects_mirror_to_agree();
}

// Under keep-alive 0 none of them is ever lost by its silence.
TEST(Limit, OfKeptSessionsOfAnIpAddressHoldsForWhomAnotherClientDisplaced) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::kept_per_address, 2)};
    ScriptedClient watcher{broker, "watcher"};
    watcher.connects();
    watcher.subscribes("will", Qos::at_most_once);
    for (const std::string name : {"a", "b", "c", "d", "e"}) {
        ScriptedClient another{broker, name, 7000};
        another.connects(false, 0);
        another.says(Willtopicupd{Qos::at_most_once, false, "will"});
        another.hears<Willtopicresp>();
        another.says(Willmsgupd{as_octets(name)});
        another.hears<Willmsgresp>();
    }
    for (const std::string name : {"a", "b"}) watcher.hears_publish(name);
    watcher.hears_nothing();
    EXPECT_THAT(broker.core.client_ids(), testing::UnorderedElementsAre("c", "d", "e", "watcher"));
}

TEST(Limit, OfSessionsIsMadeRoomForByTheIpAddressThatLeftMostKeptOnesBehind) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::sessions, 4)};
    leaves_kept_session(broker, "robot", 9);
    for (const std::string name : {"a", "b", "c"}) leaves_kept_session(broker, name, 8);
    ScriptedClient late{broker, "late"};
    late.connects();
    EXPECT_THAT(broker.core.client_ids(), testing::UnorderedElementsAre("b", "c", "late", "robot"));
    EXPECT_EQ(broker.core.counters().sessions_forgotten, 1u);
    ScriptedClient later{broker, "later"};
    later.connects();
    // Nobody who was promised a session loses his only one.
    ScriptedClient last{broker, "last"};
    last.says(last.connect());
    EXPECT_EQ(last.hears<Connack>().return_code, ReturnCode::congestion);
    EXPECT_THAT(broker.core.client_ids(),
                testing::UnorderedElementsAre("c", "late", "later", "robot"));
}

/// A message of 60,000 octets to that many clients, each of which knows its topic by another id, so
/// that no two hear the same octets.
void publish_to_many(ScriptedBroker& broker, std::size_t clients, Qos qos) {
    ScriptedClient publisher{broker, "publisher"};
    publisher.connects();
    const TopicId topic = publisher.registers("map");
    for (std::size_t n = 0; n < clients; ++n) {
        ScriptedClient client{broker, "client" + std::to_string(n)};
        client.connects();
        for (std::size_t other = 0; other < n % 2; ++other) client.registers("another");
        client.subscribes("map", qos);
    }
    const std::string map(60'000, 'x');
    const Octets octets = ScriptedClient::encoded(Publish{
        false, qos, false, TopicIdType::normal, topic, publisher.next_msg_id(), as_octets(map)});
    broker.core.on_datagram(broker.now, broker.via, publisher.address.endpoint, octets,
                            broker.actions);
}

TEST(Limit, OfOctetsToSendAtOnceDropsTheRestOfAHugeFanOut) {
    constexpr std::size_t limit = std::size_t{64} << 20U;
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once}) {
        ScriptedBroker broker;
        publish_to_many(broker, 1'300, qos);
        EXPECT_GE(broker.actions.octets_held(), limit);
        EXPECT_LT(broker.actions.octets_held(), limit + 65'536);
        EXPECT_GT(broker.dropped(Drop::output_full), 100u);
        EXPECT_LT(broker.dropped(Drop::output_full), 300u);
        broker.core.check_invariants();
    }
}

TEST(Limit, OfRetainedMessagesIsAnsweredByCongestionButReplacingAndDeletingGoOn) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::retained_messages, 1)};
    ScriptedClient client{broker, "client"};
    client.connects();
    const TopicId one = client.registers("one");
    const TopicId two = client.registers("two");
    client.publishes(one, "a", Qos::at_least_once, true);
    client.publishes(one, "b", Qos::at_least_once, true);
    const auto refused = [&] {
        client.says(Publish{false, Qos::at_least_once, true, TopicIdType::normal, two, MsgId{99},
                            as_octets("x")});
        return client.hears<Puback>().return_code;
    };
    EXPECT_EQ(refused(), ReturnCode::congestion);
    EXPECT_EQ(broker.dropped(Drop::no_room), 1u);
    client.publishes(one, "", Qos::at_least_once, true);
    client.publishes(two, "x", Qos::at_least_once, true);
}

TEST(Limit, OfLevelsInAFilterIsAnsweredByNotSupported) {
    ScriptedBroker broker;
    ScriptedClient client{broker, "client"};
    client.connects();
    std::string filter = "+";
    for (int level = 1; level < 128; ++level) filter += "/+";
    client.subscribes(filter);
    const auto refused = [&](const std::string& deeper) {
        client.says(
            Subscribe{false, Qos::at_most_once, MsgId{9}, {TopicIdType::normal, deeper, {}}});
        return client.hears<Suback>().return_code;
    };
    EXPECT_EQ(refused(filter + "/+"), ReturnCode::not_supported);
    for (int level = 128; level < 32'000; ++level) filter += "/a";
    EXPECT_EQ(refused(filter), ReturnCode::not_supported);
    EXPECT_EQ(broker.dropped(Drop::invalid_topic), 2u);
    std::ranges::replace(filter, '+', 'a');
    client.publishes(client.registers(filter), "names may be as deep as they like");
}

TEST(Limit, OfClientIdOctetsIsAnsweredByNotSupported) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::client_id_octets, 5)};
    ScriptedClient fits{broker, "12345"};
    ScriptedClient longer{broker, "123456"};
    fits.connects();
    longer.says(longer.connect());
    EXPECT_EQ(longer.hears<Connack>().return_code, ReturnCode::not_supported);
}

TEST(Limit, OfUnreleasedQos2PublishesForgetsTheOldest) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::unreleased_per_session, 2)};
    ScriptedClient client{broker, "client"};
    client.connects();
    const TopicId topic = client.registers("a");
    for (std::uint16_t id = 10; id < 13; ++id) {
        client.says(Publish{false, Qos::exactly_once, false, TopicIdType::normal, topic, MsgId{id},
                            as_octets("x")});
        client.hears<Pubrec>();
    }
    EXPECT_EQ(broker.core.image("client")->unreleased, (std::vector{MsgId{11}, MsgId{12}}));
}

TEST(Limit, OfAnUnknownAddressHoldsForConnectToo) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::stranger_datagrams_per_second, 3)};
    ScriptedClient flood{broker, "flood"};
    for (int i = 0; i < 10; ++i) {
        Connect wrong = flood.connect();
        wrong.protocol_id = 9;
        flood.says(wrong);
    }
    EXPECT_EQ(flood.unheard(), 3u);
    EXPECT_EQ(broker.dropped(Drop::stranger_rate), 7u);
    flood.ignores_what_came();
    broker.waits(1s);
    flood.connects();  // from here on its address has a session
    for (int i = 0; i < 10; ++i) flood.says(Pingreq{});
    EXPECT_EQ(flood.unheard(), 10u);
}

TEST(Limit, OfAnUnknownAddressHoldsForPublishesWithoutConnection) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::stranger_datagrams_per_second, 3)};
    ScriptedClient subscriber{broker, "subscriber"};
    ScriptedClient sensor{broker, "sensor"};
    subscriber.connects();
    subscriber.subscribes("predefined/seven", Qos::at_most_once);
    for (int i = 0; i < 10; ++i) {
        sensor.says(Publish{false, Qos::without_connection, false, TopicIdType::predefined,
                            TopicId{7}, no_msg_id, as_octets("x")});
    }
    EXPECT_EQ(subscriber.unheard(), 3u);
    EXPECT_EQ(broker.dropped(Drop::stranger_rate), 7u);
}

TEST(Limit, OfAnUnknownIpAddressHoldsForAllItsPortsTogether) {
    ScriptedBroker broker{
        options_with<std::size_t>(&Limits::address_stranger_datagrams_per_second, 3)};
    const auto is_answered = [&broker](std::uint8_t machine, std::uint16_t port) {
        ScriptedClient stranger{broker, "stranger", port};
        stranger.address.endpoint.address[3] = machine;
        stranger.says(Pingreq{});
        return stranger.unheard() == 1;
    };
    for (std::uint16_t port = 1; port <= 10; ++port) EXPECT_EQ(is_answered(8, port), port <= 3);
    EXPECT_EQ(broker.dropped(Drop::stranger_rate), 7u);
    EXPECT_TRUE(is_answered(9, 1));
    broker.waits(1s);
    EXPECT_TRUE(is_answered(8, 11));
}

TEST(Limit, OfAnUnknownAddressHoldsForWillsToo) {
    ScriptedBroker broker{options_with<std::size_t>(&Limits::stranger_datagrams_per_second, 3)};
    ScriptedClient client{broker, "client"};
    client.says(client.connect(true, 0, true));
    client.hears<Willtopicreq>();
    for (int i = 0; i < 10; ++i) client.says(Willtopic{Qos::at_most_once, false, "will"});
    EXPECT_EQ(client.unheard(), 2u);
    EXPECT_EQ(broker.dropped(Drop::stranger_rate), 8u);
    for (int i = 0; i < 10; ++i) client.says(Willmsg{as_octets("x")});
    EXPECT_EQ(broker.dropped(Drop::stranger_rate), 18u);
}

/// At most 20 answers of a kind a second, to strangers from ever new addresses.
class AnswersToStrangers : public testing::Test {
protected:
    /// How many of so many newcomers hear something when each `says()` one thing.
    template <typename Says>
    std::size_t answered(unsigned flood, Says&& says) {
        std::size_t answered = 0;
        for (unsigned i = 0; i < flood; ++i) {
            ++strangers;
            ScriptedClient stranger{broker, "s" + std::to_string(strangers), strangers};
            stranger.address.endpoint.address[2] = static_cast<std::uint8_t>(strangers % 251);
            says(stranger);
            answered += stranger.unheard();
        }
        return answered;
    }
    std::size_t pings_answered(unsigned flood) {
        return answered(flood, [](ScriptedClient& stranger) { stranger.says(Pingreq{}); });
    }
    std::uint64_t dropped() const { return broker.dropped(Drop::stranger_rate); }

    ScriptedBroker broker{options_with<std::size_t>(&Limits::stranger_answers_per_second, 20)};
    std::uint16_t strangers = 0;
};

TEST_F(AnswersToStrangers, AreSpreadAndHoldUpNobodyElse) {
    ScriptedClient client{broker, "client"};
    client.connects();
    EXPECT_EQ(pings_answered(100), 2u);  // a tenth of a second's
    EXPECT_EQ(dropped(), 98u);
    for (int turn = 0; turn < 20; ++turn) {
        broker.waits(50ms);
        EXPECT_EQ(pings_answered(10), 1u) << turn;
    }
    client.says(Pingreq{});
    client.hears<Pingresp>();
    ScriptedClient newcomer{broker, "newcomer"};
    newcomer.connects();
    broker.waits(10s);
    EXPECT_EQ(pings_answered(100), 2u);  // nothing was saved up
}

TEST_F(AnswersToStrangers, AreFewToConnectsThatAreRefusedAndAsManyAsComeToThoseThatAreNot) {
    EXPECT_EQ(answered(100,
                       [](ScriptedClient& stranger) {
                           Connect wrong = stranger.connect();
                           wrong.protocol_id = 9;
                           stranger.says(wrong);
                       }),
              2u);
    EXPECT_EQ(dropped(), 98u);
    const auto connects = [](ScriptedClient& stranger) { stranger.says(stranger.connect()); };
    EXPECT_EQ(answered(100, connects), 100u);
    EXPECT_EQ(answered(100,
                       [](ScriptedClient& stranger) {
                           stranger.says(stranger.connect(true, 0, true));
                           stranger.says(Willtopic{Qos::at_most_once, false, "will"});
                           stranger.says(Willmsg{as_octets("x")});
                       }),
              300u);
    EXPECT_EQ(broker.core.session_count(), 200u);
    broker.core.set_congested(true);
    broker.waits(10s);
    EXPECT_EQ(answered(100, connects), 2u);
    EXPECT_EQ(dropped(), 196u);
}

TEST_F(AnswersToStrangers, AreFewWhereAWillIsAskedForOnceMore) {
    const auto says_all_twice = [](ScriptedClient& stranger) {
        for (int i = 0; i < 2; ++i) stranger.says(stranger.connect(true, 0, true));
        for (int i = 0; i < 2; ++i) stranger.says(Willtopic{Qos::at_most_once, false, "will"});
    };
    EXPECT_EQ(answered(100, says_all_twice), 202u);
    EXPECT_EQ(dropped(), 198u);
}

TEST_F(AnswersToStrangers, AreFewToThoseWhoSearchAGatewayAndToAllThatListen) {
    EXPECT_EQ(pings_answered(100), 2u);
    EXPECT_EQ(answered(100, [](ScriptedClient& stranger) { stranger.says(Searchgw{1}); }), 2u)
        << "as many as if there were no other flood";
    EXPECT_EQ(broker.multicasts.size(), 2u);
    EXPECT_EQ(dropped(), 196u);
}

TEST_F(AnswersToStrangers, AreBesideThoseToClientsWithKeys) {
    EXPECT_EQ(pings_answered(100), 2u);
    const auto with_key = [](ScriptedClient& client) {
        client.via.packets = Endpoint::Packets::sealed;
    };
    EXPECT_EQ(answered(10,
                       [&](ScriptedClient& client) {
                           with_key(client);
                           client.says(Pingreq{});
                       }),
              10u);
    broker.core.set_congested(true);
    EXPECT_EQ(answered(10,
                       [&](ScriptedClient& client) {
                           with_key(client);
                           client.says(client.connect());
                       }),
              10u);
}

/// A broker whose owner is short of memory.
class Full : public testing::Test {
protected:
    void SetUp() override {
        robot.connects();
        pose = robot.registers("pose");
        robot.publishes(pose, "kept", Qos::at_least_once, true);
        broker.core.set_full(true);
    }
    ReturnCode answer_to(Qos qos, bool retain, std::string_view data) {
        robot.says(
            Publish{false, qos, retain, TopicIdType::normal, pose, MsgId{99}, as_octets(data)});
        return robot.hears<Puback>().return_code;
    }

    ScriptedBroker broker;
    ScriptedClient robot{broker, "robot"};
    TopicId pose{};
};

TEST_F(Full, WhatWouldStayIsAnsweredByCongestion) {
    ScriptedClient another{broker, "another"};
    another.says(another.connect());
    EXPECT_EQ(another.hears<Connack>().return_code, ReturnCode::congestion);

    robot.says(Register{no_topic_id, MsgId{9}, "new"});
    EXPECT_EQ(robot.hears<Regack>().return_code, ReturnCode::congestion);
    robot.says(
        Subscribe{false, Qos::at_most_once, MsgId{9}, {TopicIdType::normal, "new/#", no_topic_id}});
    EXPECT_EQ(robot.hears<Suback>().return_code, ReturnCode::congestion);
    robot.says(Willtopicupd{Qos::at_most_once, false, "will"});
    EXPECT_EQ(robot.hears<Willtopicresp>().return_code, ReturnCode::congestion);
    robot.says(Willmsgupd{as_octets("gone")});
    EXPECT_EQ(robot.hears<Willmsgresp>().return_code, ReturnCode::congestion);
    EXPECT_EQ(answer_to(Qos::at_least_once, false, "x"), ReturnCode::congestion);
    EXPECT_EQ(answer_to(Qos::exactly_once, false, "x"), ReturnCode::congestion);
    EXPECT_EQ(answer_to(Qos::at_most_once, true, "x"), ReturnCode::congestion);
    EXPECT_EQ(broker.dropped(Drop::no_room), 8u);

    broker.core.set_full(false);
    another.connects();
    robot.registers("new");
}

// 146 of them, with 20,000 topic ids each, filled the memory and locked all robots out.
TEST_F(Full, KeptSessionsThatOneIpAddressLeftBehindGo) {
    broker.core.set_full(false);
    leaves_kept_session(broker, "alone", 9);
    for (const std::string name : {"a", "b", "c"}) leaves_kept_session(broker, name, 8);
    broker.core.set_full(true);
    for (int i = 0; i < 5; ++i) robot.publishes(pose, "x");  // one goes with each datagram
    EXPECT_THAT(broker.core.client_ids(), testing::UnorderedElementsAre("alone", "c", "robot"));
    EXPECT_EQ(broker.core.counters().sessions_forgotten, 2u);
}

TEST_F(Full, AWillConnectHearsCongestionAfterThePrompts) {  // G13
    robot.says(robot.connect(false, 0, true));
    robot.hears<Willtopicreq>();
    robot.says(Willtopic{Qos::at_most_once, false, "will"});
    robot.hears<Willmsgreq>();
    robot.says(Willmsg{as_octets("gone")});
    EXPECT_EQ(robot.hears<Connack>().return_code, ReturnCode::congestion);
    EXPECT_FALSE(broker.core.image("robot")->will.has_value());
}

TEST_F(Full, WhatIsThereGoesOnAndCanGo) {
    broker.core.set_full(false);
    ScriptedClient watcher{broker, "watcher"};
    watcher.connects(false);
    watcher.subscribes("pose", Qos::at_most_once);
    EXPECT_TRUE(watcher.hears_publish("kept").retain);
    broker.core.set_full(true);

    watcher.connects(false);
    watcher.subscribes("pose", Qos::at_most_once);  // it has this one already
    EXPECT_TRUE(watcher.hears_publish("kept").retain);
    robot.publishes(pose, "passes");
    watcher.hears_publish("passes");
    robot.registers("pose");
    robot.publishes(pose, "", Qos::at_least_once, true);  // deletes
    EXPECT_EQ(broker.core.census().retained, 0u);
    robot.says(Willtopicupd{Qos::at_most_once, false, ""});
    EXPECT_EQ(robot.hears<Willtopicresp>().return_code, ReturnCode::accepted);
}

TEST_F(Full, Qos0IsNotKeptForASleeper) {
    broker.core.set_full(false);
    ScriptedClient sleeper{broker, "sleeper"};
    sleeper.connects();
    sleeper.subscribes("pose", Qos::at_most_once);
    sleeper.hears_publish("kept");
    sleeper.says(Disconnect{true, 60});
    broker.core.set_full(true);
    robot.publishes(pose, "x");
    EXPECT_EQ(broker.core.census().queued, 0u);
    EXPECT_EQ(broker.dropped(Drop::no_room), 1u);
}

TEST(Census, CountsWhatIsThere) {
    ScriptedBroker broker;
    ScriptedClient awake{broker, "awake"};
    ScriptedClient asleep{broker, "asleep"};
    ScriptedClient gone{broker, "gone"};
    ScriptedClient publisher{broker, "publisher"};
    for (auto* client : {&awake, &asleep, &gone, &publisher}) client->connects(false);
    for (auto* client : {&awake, &asleep, &gone}) client->subscribes("a", Qos::exactly_once);
    asleep.says(mqttsn::Disconnect{true, 60});
    gone.says(mqttsn::Disconnect{});
    const TopicId topic = publisher.registers("a");
    publisher.publishes(topic, "1", Qos::at_least_once, true);
    publisher.publishes(topic, "2", Qos::at_least_once);
    publisher.says(Publish{false, Qos::exactly_once, false, TopicIdType::normal, topic, MsgId{99},
                           as_octets("3")});
    const Census census = broker.core.census();
    const auto in = [&](SessionState state) {
        return census.sessions[static_cast<std::size_t>(state)];
    };
    EXPECT_EQ(in(SessionState::active), 2u);
    EXPECT_EQ(in(SessionState::asleep), 1u);
    EXPECT_EQ(in(SessionState::disconnected), 1u);
    EXPECT_EQ(census.subscriptions, 3u);
    EXPECT_EQ(census.topics, 4u);
    EXPECT_EQ(census.queued, 9u);
    EXPECT_EQ(census.longest_queue, 3u);
    EXPECT_EQ(census.in_flight, 1u);
    EXPECT_EQ(census.unreleased, 1u);
    EXPECT_EQ(census.retained, 1u);
}

}  // namespace
}  // namespace romano::broker::limits_test
