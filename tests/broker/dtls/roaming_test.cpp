// Clients that have a Connection ID of the broker's (RFC 9146) and change their address.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/broker/dtls/client.h"

namespace romano::dtls::roaming_test {
namespace {

using namespace broker_with_dtls;
using broker::Actions;
using mqttsn::MsgType;

const Octets pong = octets_of(mqttsn::Pingresp{});

struct Roamer : OwnClient {
    Roamer() : OwnClient("a", key_a) {}

    Octets record_of(const Octets& message) {
        EXPECT_TRUE(end.seal(message));
        return std::exchange(outbox, {}).at(0);
    }
    /// All that it is told at once.
    std::vector<MsgType> hear_all(const std::vector<Sent>& sent) {
        received.clear();
        std::vector<MsgType> types;
        for (const Sent& each : sent) hear(each.octets);
        for (const Octets& message : received) types.push_back(mqttsn::decode_frame(message)->type);
        return types;
    }
};

struct ARoamingClient : testing::Test {
    void SetUp() override {
        ASSERT_TRUE(a.connect(broker));
        ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    }
    std::vector<Sent> take(const Endpoint& from, const Octets& datagram) {
        return broker.take(from, datagram);
    }
    std::uint64_t moved() const { return broker.listener.clients().counters().moved; }
    /// Somebody publishes `octets` on "ab" without a connection: what leaves for whom.
    std::vector<Sent> publish(std::uint8_t octets) {
        Octets message{static_cast<std::uint8_t>(7 + octets), 12, 0x62, 'a', 'b', 0, 0};
        message.resize(message[0], 'x');
        Actions actions;
        broker.core.on_datagram(broker.now, endpoint(1, 1883), endpoint(99, 9), message, actions);
        return broker.drain(actions);
    }

    Broker broker{1};
    Roamer a;
};

TEST_F(ARoamingClient, HasAnIdOfItsBrokersInEveryRecord) {
    EXPECT_TRUE(a.end.may_roam());
    const Octets record = a.record_of(ping);
    EXPECT_EQ(record[0], 25);
    EXPECT_EQ(record[11], 1) << "the broker's place";
    EXPECT_EQ(record.size(), ping.size() + overhead(Suite::aes_128_ccm_8, 8));
    OwnClient another{"a", key_a};
    ASSERT_TRUE(another.connect(broker));
    ASSERT_EQ(another.ask(broker, connect_as("a")), MsgType::connack);
    EXPECT_FALSE(
        std::equal(record.begin() + 11, record.begin() + 19, another.last_sent.begin() + 11));
}

TEST_F(ARoamingClient, GoesOnFromAnotherAddressWithoutAHandshakeOrAConnect) {
    const auto answers = take(other_place, a.record_of(ping));
    ASSERT_FALSE(answers.empty());
    for (const Sent& answer : answers) EXPECT_EQ(answer.to, other_place);
    EXPECT_THAT(a.hear_all(answers), testing::ElementsAre(MsgType::pingreq, MsgType::pingresp));
    EXPECT_EQ(broker.core.session_count(), 1U);
    EXPECT_EQ(broker.listener.handshakes().agreed(), 1U);
    EXPECT_EQ(moved(), 1U);
}

TEST_F(ARoamingClient, IsAskedWhetherItIsThereUntilItHasAnswered) {
    (void)take(other_place, a.record_of(ping));
    EXPECT_THAT(a.hear_all(take(other_place, a.record_of(ping))),
                testing::ElementsAre(MsgType::pingreq, MsgType::pingresp));
    (void)take(other_place, a.record_of(pong));
    EXPECT_THAT(a.hear_all(take(other_place, a.record_of(ping))),
                testing::ElementsAre(MsgType::pingresp));
}

TEST_F(ARoamingClient, AnAnswerThatIsItselfHeardElsewhereProvesNothing) {
    const auto answers = take(other_place, a.record_of(pong));
    EXPECT_THAT(a.hear_all(answers), testing::ElementsAre(MsgType::pingreq));
    EXPECT_THAT(a.hear_all(take(other_place, a.record_of(ping))),
                testing::ElementsAre(MsgType::pingreq, MsgType::pingresp));
}

TEST_F(ARoamingClient, IsNotMovedByAnOlderRecordWhichIsHeededAllTheSame) {
    const Octets older = a.record_of(ping);
    (void)take(other_place, a.record_of(ping));
    (void)take(other_place, a.record_of(pong));
    const auto answers = take(place, older);
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].to, other_place);
    EXPECT_EQ(moved(), 1U);
}

TEST_F(ARoamingClient, IsSpokenToByItsNewAssociationThoughItsFinishedOfBeforeIsRepeated) {
    Roamer again;
    Roamer newest;
    ASSERT_TRUE(again.connect(broker));
    const Octets finished = again.last_sent;
    ASSERT_EQ(again.ask(broker, connect_as("a")), MsgType::connack);
    ASSERT_TRUE(newest.connect(broker));
    ASSERT_EQ(newest.ask(broker, connect_as("a")), MsgType::connack);
    ASSERT_EQ(newest.ask(broker, {7, 18, 0x02, 0, 1, 'a', 'b'}), MsgType::suback);
    const std::uint64_t opened = broker.listener.clients().counters().opened;
    EXPECT_TRUE(take(place, finished).empty());
    EXPECT_EQ(broker.listener.clients().counters().opened, opened);
    EXPECT_EQ(broker.refused(Refusal::malformed), 1U);
    EXPECT_THAT(newest.hear_all(publish(3)), testing::ElementsAre(MsgType::publish));
}

TEST_F(ARoamingClient, IsNotMovedByRepeatedOrForgedRecords) {
    const Octets record = a.record_of(ping);
    (void)take(place, record);
    EXPECT_TRUE(take(other_place, record).empty());
    EXPECT_EQ(broker.refused(Refusal::replayed), 1U);
    const Octets next = a.record_of(ping);
    for (std::size_t bit = 8 * 3; bit < 8 * next.size(); ++bit) {
        Octets forged = next;
        forged[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
        EXPECT_TRUE(take(other_place, forged).empty()) << bit;
    }
    EXPECT_EQ(moved(), 0U);
    EXPECT_EQ(take(place, next).size(), 1U);
}

TEST_F(ARoamingClient, UnknownIdsAreDroppedAndCounted) {
    Octets unknown = a.record_of(ping);
    unknown[15] ^= 1;
    EXPECT_TRUE(take(place, unknown).empty());
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1U);
    Octets cut = a.record_of(ping);
    cut.resize(16);
    EXPECT_TRUE(take(place, cut).empty());
    EXPECT_EQ(broker.refused(Refusal::malformed), 1U);
}

TEST_F(ARoamingClient, LeavesItsOldAddressToOthers) {
    (void)take(other_place, a.record_of(ping));
    (void)take(other_place, a.record_of(pong));
    for (const auto wants : {ClientEnd::Wants::none, ClientEnd::Wants::connection_id}) {
        OwnClient b{"b", key_b, ClientEnd::default_suites, wants};
        ASSERT_TRUE(b.connect(broker));
        ASSERT_EQ(b.ask(broker, connect_as("b")), MsgType::connack);
        EXPECT_EQ(b.ask(broker, ping), MsgType::pingresp);
        const auto answers = take(other_place, a.record_of(ping));
        ASSERT_EQ(answers.size(), 1U);
        EXPECT_EQ(answers[0].to, other_place);
        EXPECT_EQ(b.ask(broker, ping), MsgType::pingresp) << "and theirs is theirs";
    }
    EXPECT_EQ(broker.core.session_count(), 2U);
}

TEST_F(ARoamingClient, IsNoAmplifierForWhoeverSendsOnItsRecords) {
    const Octets subscribe{7, 18, 0x02, 0, 1, 'a', 'b'};
    ASSERT_EQ(a.ask(broker, subscribe), MsgType::suback);
    const Octets record = a.record_of(ping);
    std::size_t octets = 0;
    for (const Sent& each : take(other_place, record)) octets += each.octets.size();
    for (int n = 0; n < 20; ++n) {
        for (const Sent& each : publish(60)) {
            EXPECT_EQ(each.to, other_place);
            octets += each.octets.size();
        }
    }
    EXPECT_GT(octets, 0U);
    EXPECT_LE(octets, 3 * record.size());
    EXPECT_GT(broker.refused(Refusal::unanswered), 0U);
    (void)take(other_place, a.record_of(pong));
    for (int n = 0; n < 20; ++n) ASSERT_EQ(publish(60).size(), 1U);
}

TEST_F(ARoamingClient, SaysGoodbyeFromWhereItIs) {
    (void)take(other_place, a.record_of(ping));
    a.end.close();
    const auto answers = take(other_place, std::exchange(a.outbox, {}).at(0));
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].to, other_place);
    EXPECT_EQ(broker.listener.clients().size(), 0U);
}

TEST_F(ARoamingClient, LosesItsAssociationWithItsKey) {
    broker.listener.set_clients(std::vector<broker::ProtectedClient>{{"b", key_b}});
    EXPECT_TRUE(take(other_place, a.record_of(ping)).empty());
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1U);
}

// --- several brokers

struct ARoamingClientOfTwoBrokers : ARoamingClient {
    Broker heir{2};
};

TEST_F(ARoamingClientOfTwoBrokers, TheHeirFindsItByItsIdFromANewAddress) {
    heir.hear(broker);
    heir.adopt(broker, "a");
    const auto answers = heir.take(other_place, a.record_of(ping));
    EXPECT_THAT(a.hear_all(answers), testing::Contains(MsgType::pingresp));
    for (const Sent& answer : answers) EXPECT_EQ(answer.to, other_place);
    EXPECT_EQ(heir.core.session_count(), 1U);
    EXPECT_EQ(heir.listener.handshakes().agreed(), 0U);
}

TEST_F(ARoamingClientOfTwoBrokers, ThatItMovedIsNewsAndTheHeirSpeaksToWhereItIs) {
    heir.hear(broker);
    (void)take(other_place, a.record_of(ping));
    (void)take(other_place, a.record_of(pong));
    EXPECT_TRUE(broker.listener.clients().has_news());
    heir.hear(broker);
    heir.adopt(broker, "a");
    const auto answers = heir.take(other_place, a.record_of(ping));
    ASSERT_EQ(answers.size(), 1U) << "it knew that already";
    EXPECT_EQ(heir.listener.clients().counters().moved, 0U);
}

TEST_F(ARoamingClientOfTwoBrokers, OldNewsMoveItNotBack) {
    heir.hear(broker);
    (void)take(other_place, a.record_of(ping));
    (void)take(other_place, a.record_of(pong));
    const Told old = broker.listener.clients().to_tell();
    heir.adopt(broker, "a");
    const Endpoint third = endpoint(12, 5000);
    (void)heir.take(third, a.record_of(ping));
    (void)heir.take(third, a.record_of(pong));
    heir.listener.clients().on_told(old);
    const auto answers = heir.take(third, a.record_of(ping));
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].to, third);
    EXPECT_EQ(heir.listener.clients().counters().moved, 1U);
}

TEST_F(ARoamingClientOfTwoBrokers, TheHeirTakesNoOldRecordFromAnywhere) {
    const Octets old = a.record_of(ping);
    (void)take(place, old);
    heir.hear(broker);
    heir.adopt(broker, "a");
    EXPECT_TRUE(heir.take(other_place, old).empty());
    EXPECT_EQ(heir.refused(Refusal::replayed), 1U);
}

}  // namespace
}  // namespace romano::dtls::roaming_test
