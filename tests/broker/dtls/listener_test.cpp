// DTLS clients of a broker core, from the first ClientHello on, and whoever else sends datagrams
// there. The clients are OpenSSL's.

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "broker/protection/protected_node.h"
#include "romano/base/random.h"
#include "romano/mqttsn/decode.h"
#include "tests/broker/dtls/client.h"

namespace romano::dtls::listener_test {
namespace {

using namespace std::chrono_literals;
using namespace broker_with_dtls;
using mqttsn::MsgType;

struct AtADtlsAddress : testing::Test {
    Broker broker{1};
    Client a{"a", key_a};
};

TEST_F(AtADtlsAddress, AClientWithAKeyIsServed) {
    ASSERT_TRUE(a.connect(broker));
    EXPECT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    EXPECT_EQ(a.ask(broker, ping), MsgType::pingresp);
    EXPECT_EQ(broker.core.session_count(), 1U);
    EXPECT_EQ(broker.listener.handshakes().size(), 0U) << "OpenSSL's memory is given back";
    EXPECT_EQ(broker.listener.handshakes().agreed(), 1U);
}

TEST_F(AtADtlsAddress, GcmWorksAsCcmDoes) {
    Client gcm{"a", key_a, "PSK-AES128-GCM-SHA256"};
    ASSERT_TRUE(gcm.connect(broker));
    EXPECT_EQ(gcm.ask(broker, connect_as("a")), MsgType::connack);
    EXPECT_EQ(gcm.ask(broker, ping), MsgType::pingresp);
}

TEST_F(AtADtlsAddress, WhoHasAnotherKeyOrAnUnknownNameIsNotServedAndHearsTheSame) {
    for (const auto& [name, key] : {std::pair{"a", key_b}, std::pair{"nobody", key_b}}) {
        Client stranger{name, key};
        EXPECT_FALSE(stranger.connect(broker)) << name;
        EXPECT_FALSE(stranger.end.is_closed()) << name << ": silence, and no alert";
    }
    EXPECT_EQ(broker.listener.clients().size(), 0U);
    EXPECT_TRUE(broker.delivered.empty());
}

TEST_F(AtADtlsAddress, NobodyConnectsInAnothersName) {
    ASSERT_TRUE(a.connect(broker));
    EXPECT_EQ(a.ask(broker, connect_as("b")), MsgType::connack);
    EXPECT_EQ(a.received[0][2], 3) << "not supported";
    EXPECT_EQ(broker.refused(Refusal::foreign_client_id), 1U);
    EXPECT_EQ(broker.core.session_count(), 0U);
}

TEST_F(AtADtlsAddress, ANodeBehindAForwarderIsNobody) {
    ASSERT_TRUE(a.connect(broker));
    const std::string node = broker::protected_node_id("b");
    Octets wrapped(3 + node.size());
    (void)mqttsn::encode(mqttsn::Encapsulated{0, as_octets(node), {}}, wrapped);
    const Octets inner = connect_as("b");
    wrapped.insert(wrapped.end(), inner.begin(), inner.end());
    EXPECT_FALSE(a.ask(broker, wrapped));
    EXPECT_EQ(broker.refused(Refusal::forwarded), 1U);
}

TEST_F(AtADtlsAddress, AStrangerGetsACookieAndNoMemory) {
    for (std::uint16_t port = 1; port <= 1'000; ++port) {
        Client stranger{"a", key_a};
        stranger.end.connect();
        const auto answers = broker.take(endpoint(77, port), stranger.outbox.at(0));
        ASSERT_EQ(answers.size(), 1U);
        EXPECT_EQ(answers[0].octets[13], 3) << "HelloVerifyRequest";
        EXPECT_LE(answers[0].octets.size(), stranger.outbox.at(0).size()) << "no amplifier";
    }
    EXPECT_EQ(broker.listener.handshakes().size(), 0U);
}

TEST_F(AtADtlsAddress, ACookieIsOfOneAddressAlone) {
    a.end.connect();
    for (const Sent& answer : broker.take(place, a.outbox.at(0))) a.hear(answer.octets);
    ASSERT_EQ(a.outbox.size(), 2U);
    (void)broker.take(other_place, a.outbox[1]);
    EXPECT_EQ(broker.listener.handshakes().size(), 0U);
    (void)broker.take(place, a.outbox[1]);
    EXPECT_EQ(broker.listener.handshakes().size(), 1U);
}

TEST_F(AtADtlsAddress, HandshakesThatLeadNowhereAreBoundedAndForgotten) {
    const auto begin = [&](std::uint8_t host, std::size_t handshakes) {
        for (std::uint16_t port = 1; port <= handshakes; ++port) {
            Client stranger{"nobody", key_b};
            stranger.from = endpoint(host, port);
            (void)stranger.connect(broker);
        }
    };
    begin(77, Handshakes::most_of_host + 10);
    EXPECT_EQ(broker.listener.handshakes().size(), Handshakes::most_of_host);
    EXPECT_EQ(broker.refused(Refusal::handshake_rate), 10U);
    ASSERT_TRUE(a.connect(broker)) << "one host does not keep others out";
    EXPECT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    for (std::uint8_t host = 78; host <= 81; ++host) begin(host, Handshakes::most_of_host);
    EXPECT_EQ(broker.listener.handshakes().size(), Handshakes::most_handshakes);
    EXPECT_EQ(broker.refused(Refusal::handshake_rate), 10U + Handshakes::most_of_host);
    (void)broker.wait(1s);
    Client b{"b", key_b};
    b.from = other_place;
    ASSERT_TRUE(b.connect(broker)) << "many do for a second";
    EXPECT_EQ(broker.listener.handshakes().size(), Handshakes::most_handshakes);
    (void)broker.wait(20s);
    EXPECT_EQ(broker.listener.handshakes().size(), 0U);
    EXPECT_EQ(b.ask(broker, connect_as("b")), MsgType::connack);
}

TEST_F(AtADtlsAddress, WhoBeginsAgainAndAgainIsHeededOnceASecond) {
    for (int round = 0; round < 100; ++round) {
        Client stranger{"nobody", key_b};
        EXPECT_FALSE(stranger.connect(broker));
    }
    EXPECT_EQ(broker.refused(Refusal::handshake_rate), 99U);
    (void)broker.wait(1s);
    EXPECT_TRUE(a.connect(broker));
}

TEST_F(AtADtlsAddress, WhoFailsKeepsItsPlaceForASecond) {
    for (int round = 0; round < 100; ++round) {
        Client stranger{"a", key_a, "PSK-AES256-GCM-SHA384"};  // which is refused by an alert
        EXPECT_FALSE(stranger.connect(broker));
    }
    EXPECT_EQ(broker.refused(Refusal::handshake_failed), 1U);
    EXPECT_EQ(broker.refused(Refusal::handshake_rate), 99U);
    EXPECT_EQ(broker.listener.handshakes().size(), 1U);
    (void)broker.wait(1s);
    EXPECT_EQ(broker.listener.handshakes().size(), 0U);
    EXPECT_TRUE(a.connect(broker));
}

TEST_F(AtADtlsAddress, ManyClientHellosInADatagramAreAnsweredOnce) {
    a.end.connect();
    Octets many;
    for (int n = 0; n < 100; ++n) many.insert(many.end(), a.outbox[0].begin(), a.outbox[0].end());
    EXPECT_EQ(broker.take(place, many).size(), 1U);
    EXPECT_EQ(broker.refused(Refusal::malformed), 1U);
}

TEST_F(AtADtlsAddress, TheLastFlightIsSentAgainWhenItWasLost) {
    a.end.connect();
    while (!a.outbox.empty()) {
        const auto sent = std::exchange(a.outbox, {});
        for (const Octets& datagram : sent) {
            const auto answers = broker.take(place, datagram);
            if (broker.listener.clients().size() != 0) continue;  // the answer to Finished is lost
            for (const Sent& answer : answers) a.hear(answer.octets);
        }
    }
    ASSERT_FALSE(a.end.is_connected());
    // OpenSSL's timer is the real clock's: a second.
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (a.outbox.empty() && std::chrono::steady_clock::now() < deadline) {
        std::this_thread::sleep_for(10ms);
        a.end.on_time();
    }
    a.exchange(broker);
    EXPECT_TRUE(a.end.is_connected());
    EXPECT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
}

TEST_F(AtADtlsAddress, ClosingIsAnsweredAndEndsTheAssociation) {
    ASSERT_TRUE(a.connect(broker));
    ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    a.end.close();
    ASSERT_EQ(a.outbox.size(), 1U);
    const auto answers = broker.take(place, a.outbox[0]);
    ASSERT_EQ(answers.size(), 1U);
    EXPECT_EQ(answers[0].octets[0], 21) << "an alert";
    EXPECT_EQ(broker.listener.clients().size(), 0U);
    EXPECT_EQ(broker.listener.clients().counters().closed, 1U);
}

TEST_F(AtADtlsAddress, AClientBeginsAnewFromTheSamePortAndNobodyCanDoItInItsPlace) {
    ASSERT_TRUE(a.connect(broker));
    ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    Client thief{"a", key_b};  // at the same address
    EXPECT_FALSE(thief.connect(broker));
    EXPECT_EQ(a.ask(broker, ping), MsgType::pingresp) << "the association of before goes on";
    (void)broker.wait(1s);
    for (int round = 0; round < 5; ++round) {
        Client again{"a", key_a};
        ASSERT_TRUE(again.connect(broker));
        ASSERT_EQ(again.ask(broker, connect_as("a")), MsgType::connack);
        EXPECT_EQ(again.ask(broker, ping), MsgType::pingresp);
    }
    EXPECT_EQ(broker.listener.clients().size(), 2U) << "a client has two at most";
}

TEST_F(AtADtlsAddress, AWithdrawnKeyEndsItsAssociations) {
    ASSERT_TRUE(a.connect(broker));
    ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    const std::vector<broker::ProtectedClient> others{{"b", key_b}};
    broker.listener.set_clients(others);
    EXPECT_FALSE(a.ask(broker, ping));
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1U);
}

TEST_F(AtADtlsAddress, SeveralRecordsOfADatagramAreSeveralMessages) {
    ASSERT_TRUE(a.connect(broker));
    ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    ASSERT_TRUE(a.end.seal(ping));
    ASSERT_TRUE(a.end.seal(ping));
    ASSERT_EQ(a.outbox.size(), 2U);
    Octets both = a.outbox[0];
    both.insert(both.end(), a.outbox[1].begin(), a.outbox[1].end());
    EXPECT_EQ(broker.take(place, both).size(), 2U);
}

TEST_F(AtADtlsAddress, RepeatedReflectedForgedAndCutRecordsAreRefused) {
    ASSERT_TRUE(a.connect(broker));
    ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    ASSERT_EQ(a.ask(broker, ping), MsgType::pingresp);
    const Octets record = a.last_sent;
    const Octets answer = a.last_heard;
    const std::size_t before = broker.delivered.size();
    EXPECT_TRUE(broker.take(place, record).empty());
    EXPECT_EQ(broker.refused(Refusal::replayed), 1U);
    EXPECT_TRUE(broker.take(other_place, record).empty());
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1U);
    EXPECT_TRUE(broker.take(place, answer).empty()) << "its own, sent back";
    EXPECT_EQ(broker.refused(Refusal::bad_tag), 1U);

    Random random{1};
    for (int round = 0; round < 200'000; ++round) {
        Octets bad = round % 2 == 0 ? record : answer;
        switch (round % 5) {
            case 0:
                bad.resize(random.below(static_cast<std::uint32_t>(bad.size())));
                break;
            case 1:  // a number that was not there yet, and nothing else
                bad[5 + random.below(6)] ^= static_cast<std::uint8_t>(1 + random.below(255));
                break;
            case 2:
                for (std::size_t at = 11; at < bad.size(); ++at) {
                    bad[at] = static_cast<std::uint8_t>(random.next());
                }
                break;
            default:
                bad[random.below(static_cast<std::uint32_t>(bad.size()))] ^=
                    static_cast<std::uint8_t>(1 << random.below(8));
        }
        (void)broker.take(place, bad);
    }
    EXPECT_EQ(broker.delivered.size(), before);
    EXPECT_EQ(broker.listener.clients().size(), 1U);
    EXPECT_EQ(a.ask(broker, ping), MsgType::pingresp) << "its own go on";
}

TEST_F(AtADtlsAddress, LateRecordsAreTakenOnceInsideTheWindow) {
    ASSERT_TRUE(a.connect(broker));
    ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    for (int n = 0; n < 100; ++n) ASSERT_TRUE(a.end.seal(ping));
    const auto records = std::exchange(a.outbox, {});
    std::size_t answered = 0;
    for (std::size_t at = records.size(); at-- > 0;)
        answered += broker.take(place, records[at]).size();
    EXPECT_EQ(answered, 64U);
    for (const Octets& record : records) EXPECT_TRUE(broker.take(place, record).empty());
}

// --- several brokers

struct WithAnHeir : AtADtlsAddress {
    void SetUp() override {
        ASSERT_TRUE(a.connect(broker));
        heir.hear(broker);
        ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
    }
    Broker heir{2};
};

TEST_F(WithAnHeir, TheClientGoesOnWithoutAHandshake) {
    heir.hear(broker);
    heir.adopt(broker, "a");
    EXPECT_EQ(a.ask(heir, ping), MsgType::pingresp);
    EXPECT_EQ(heir.listener.handshakes().agreed(), 0U);
    broker.hear(heir);
    EXPECT_EQ(a.ask(broker, ping), MsgType::pingresp) << "and back";
    EXPECT_EQ(a.ask(broker, ping), MsgType::pingresp);
}

TEST_F(WithAnHeir, TheHeirTakesNoOldRecord) {
    ASSERT_EQ(a.ask(broker, ping), MsgType::pingresp);
    const Octets old = a.last_sent;
    heir.hear(broker);
    heir.adopt(broker, "a");
    EXPECT_TRUE(heir.take(place, old).empty());
    EXPECT_EQ(heir.refused(Refusal::replayed), 1U);
}

TEST_F(WithAnHeir, ThatABrokerBeginsToSpeakIsNews) {
    heir.hear(broker);
    heir.adopt(broker, "a");
    EXPECT_FALSE(heir.listener.clients().has_news());
    ASSERT_EQ(a.ask(heir, ping), MsgType::pingresp);
    EXPECT_TRUE(heir.listener.clients().has_news());
}

TEST_F(WithAnHeir, AClosedAssociationIsClosedEverywhere) {
    heir.hear(broker);
    a.end.close();
    (void)broker.take(place, a.outbox.at(0));
    heir.hear(broker);
    EXPECT_EQ(heir.listener.clients().size(), 0U);
}

TEST_F(WithAnHeir, ANewcomerHearsOfAllThatThereIs) {
    heir.hear(broker);
    Broker newcomer{3};
    newcomer.hear(broker);
    EXPECT_EQ(newcomer.listener.clients().size(), 0U) << "nothing is new";
    broker.listener.clients().tell_all();
    newcomer.hear(broker);
    EXPECT_EQ(newcomer.listener.clients().size(), 1U);
}

}  // namespace
}  // namespace romano::dtls::listener_test
