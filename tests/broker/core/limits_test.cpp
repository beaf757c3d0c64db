// Every table has a bound and a stated behaviour beyond it (promise P8); what is there can be
// counted. Sessions, queues, topics and subscriptions that are full: see their procedures' tests.

#include "broker/core/limits.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker {
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
}  // namespace romano::broker
