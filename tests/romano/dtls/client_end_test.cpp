// A client's end at servers: OpenSSL's, whose record layer is not ours, and a broker, with a
// Connection ID.

#include "romano/dtls/client_end.h"

#include <gtest/gtest.h>

#include <chrono>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "romano/base/random.h"
#include "tests/broker/dtls/client.h"
#include "tests/romano/dtls/openssl_ends.h"

namespace romano::dtls::client_end_test {
namespace {

using namespace std::chrono_literals;
using Octets = std::vector<std::uint8_t>;
using Messages = std::vector<Octets>;

const protection::Key psk{{7, 7, 7}};
const Octets question{1, 2, 3};
const Octets answer{4, 5, 6, 7};

Octets copy(Bytes octets) {
    return {octets.begin(), octets.end()};
}

/// All records of epoch 1 that left, each with number and nonce of its own.
class Numbers {
public:
    void note(Bytes datagram) {
        while (const auto record = first_record(datagram, 8)) {
            datagram = datagram.subspan(record->whole.size());
            if (record->epoch != 1) continue;
            EXPECT_TRUE(numbers_.insert(record->number).second) << record->number << " twice";
            EXPECT_TRUE(nonces_.insert(be64(record->body, 0)).second) << "a nonce twice";
        }
    }
    [[nodiscard]] std::size_t count() const { return numbers_.size(); }

private:
    std::set<std::uint64_t> numbers_;
    std::set<std::uint64_t> nonces_;
};

/// OpenSSL's timers are the real clock's: a second.
template <typename End>
void wait_for_a_repetition(End& client, const std::vector<Octets>& outbox) {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (outbox.empty() && std::chrono::steady_clock::now() < deadline) {
        std::this_thread::sleep_for(10ms);
        client.on_time();
    }
}

struct AtAnOpensslServer : testing::TestWithParam<const char*> {
    std::vector<Octets> from_client() {
        auto sent = std::exchange(to_server, {});
        for (const Octets& datagram : sent) numbers.note(datagram);
        return sent;
    }
    /// Until nobody has anything to say.
    void exchange() {
        while (!to_server.empty() || !to_client.empty()) {
            for (const Octets& datagram : from_client()) hear_at_server(datagram);
            for (const Octets& datagram : std::exchange(to_client, {})) hear(datagram);
        }
    }
    void hear(const Octets& datagram) {
        const Bytes message = client.open(datagram);
        if (!message.empty()) heard.push_back(copy(message));
    }
    void hear_at_server(const Octets& datagram) {
        const Bytes message = server.open(datagram);
        if (!message.empty()) heard_at_server.push_back(copy(message));
    }
    void connect() {
        client.connect();
        exchange();
        ASSERT_TRUE(client.is_connected());
        ASSERT_TRUE(server.is_connected());
    }
    /// A message each way.
    bool speak() {
        heard.clear();
        heard_at_server.clear();
        if (!client.seal(question) || !server.seal(answer)) return false;
        exchange();
        return heard_at_server == Messages{question} && heard == Messages{answer};
    }
    Octets record_of_server() {
        EXPECT_TRUE(server.seal(answer));
        return std::exchange(to_client, {}).at(0);
    }

    std::vector<Octets> to_server;
    std::vector<Octets> to_client;
    Numbers numbers;
    Messages heard;
    Messages heard_at_server;
    ClientEnd client{"a", psk, [this](Bytes datagram) { to_server.push_back(copy(datagram)); },
                     GetParam()};
    openssl_ends::Server server{
        "a", psk, [this](Bytes datagram) { to_client.push_back(copy(datagram)); }, GetParam()};
};
INSTANTIATE_TEST_SUITE_P(EverySuite, AtAnOpensslServer,
                         testing::Values("PSK-AES128-CCM8", "PSK-AES128-GCM-SHA256"));

TEST_P(AtAnOpensslServer, MessagesGoBothWaysInRecordsOfOurs) {
    connect();
    EXPECT_FALSE(client.may_roam()) << "the server gives no Connection ID";
    for (int n = 0; n < 1'000; ++n) ASSERT_TRUE(speak()) << n;
    EXPECT_EQ(numbers.count(), 1'001U) << "Finished, and a thousand";
}

TEST_P(AtAnOpensslServer, NumbersGoOnAfterThoseOfAHandshakeThatRepeatedItsLastFlight) {
    client.connect();
    std::vector<Octets> last_flight;  // of the server
    while (!to_server.empty()) {
        for (const Octets& datagram : from_client()) hear_at_server(datagram);
        if (server.is_connected()) last_flight = std::exchange(to_client, {});  // it is lost
        for (const Octets& datagram : std::exchange(to_client, {})) hear(datagram);
    }
    ASSERT_FALSE(client.is_connected());
    wait_for_a_repetition(client, to_server);
    exchange();
    ASSERT_TRUE(client.is_connected());
    EXPECT_EQ(numbers.count(), 2U) << "Finished twice";
    EXPECT_TRUE(speak());
    for (const Octets& datagram : last_flight) hear(datagram);  // it was late
    EXPECT_TRUE(to_server.empty()) << "of two that know each other the server has the last flight";
    EXPECT_TRUE(speak());
    EXPECT_EQ(numbers.count(), 4U);
}

TEST_P(AtAnOpensslServer, EachHandshakeHasItsOwnNumbers) {
    connect();
    ASSERT_TRUE(speak());
    openssl_ends::Server another{
        "a", psk, [this](Bytes datagram) { to_client.push_back(copy(datagram)); }, GetParam()};
    client.connect();
    EXPECT_FALSE(client.is_connected());
    while (!to_server.empty()) {
        for (const Octets& datagram : std::exchange(to_server, {})) (void)another.open(datagram);
        for (const Octets& datagram : std::exchange(to_client, {})) hear(datagram);
    }
    ASSERT_TRUE(client.is_connected());
    ASSERT_TRUE(client.seal(question));
    const Octets record = to_server.at(0);
    EXPECT_EQ(first_record(record)->number, 1U) << "after Finished";
    EXPECT_EQ(copy(another.open(record)), question);
}

TEST_P(AtAnOpensslServer, RecordsInOneDatagramWithTheLastFlightAreHeard) {
    client.connect();
    Octets last;
    while (!client.is_connected()) {
        for (const Octets& datagram : from_client()) hear_at_server(datagram);
        if (server.is_connected()) {
            ASSERT_TRUE(server.seal(answer));
            for (const Octets& datagram : std::exchange(to_client, {})) {
                last.insert(last.end(), datagram.begin(), datagram.end());
            }
            hear(last);
            break;
        }
        for (const Octets& datagram : std::exchange(to_client, {})) hear(datagram);
    }
    EXPECT_TRUE(client.is_connected());
    EXPECT_EQ(heard, Messages{answer});
}

TEST_P(AtAnOpensslServer, GoodbyeIsSaidAndAnswered) {
    connect();
    client.close();
    EXPECT_TRUE(client.is_closed());
    EXPECT_FALSE(client.seal(question));
    exchange();
    EXPECT_TRUE(server.is_closed());
    EXPECT_EQ(SSL_get_shutdown(server.ssl()) & SSL_RECEIVED_SHUTDOWN, SSL_RECEIVED_SHUTDOWN)
        << "not by an error";

    client.connect();
    openssl_ends::Server another{
        "a", psk, [this](Bytes datagram) { to_client.push_back(copy(datagram)); }, GetParam()};
    while (!to_server.empty()) {
        for (const Octets& datagram : std::exchange(to_server, {})) (void)another.open(datagram);
        for (const Octets& datagram : std::exchange(to_client, {})) hear(datagram);
    }
    ASSERT_TRUE(client.is_connected());
    another.close();
    hear(std::exchange(to_client, {}).at(0));
    EXPECT_TRUE(client.is_closed());
    ASSERT_EQ(to_server.size(), 1U) << "RFC 5246 section 7.2.1";
    EXPECT_EQ(to_server[0][0], 21) << "an alert";
}

TEST_P(AtAnOpensslServer, AWishForAnotherHandshakeIsPassedOver) {
    connect();
    ASSERT_EQ(SSL_renegotiate(server.ssl()), 1);
    ASSERT_EQ(SSL_do_handshake(server.ssl()), 1);
    ASSERT_EQ(to_client.size(), 1U);
    EXPECT_EQ(to_client[0][0], 22) << "HelloRequest";
    exchange();
    EXPECT_TRUE(client.is_connected());
    EXPECT_TRUE(to_server.empty());
    ASSERT_TRUE(client.seal(question));
    exchange();
    EXPECT_EQ(heard_at_server, Messages{question});
}

TEST_P(AtAnOpensslServer, WhatIsBentCutOrRepeatedIsNotHeardAndEndsNothing) {
    connect();
    const Octets record = record_of_server();
    Random random{1};
    for (int round = 0; round < 20'000; ++round) {
        Octets bad = record;
        if (round % 3 == 0) {
            bad.resize(random.below(static_cast<std::uint32_t>(bad.size())));
        } else {
            bad[random.below(static_cast<std::uint32_t>(bad.size()))] ^=
                static_cast<std::uint8_t>(1U << random.below(8));
        }
        hear(bad);
    }
    EXPECT_TRUE(heard.empty());
    EXPECT_TRUE(client.is_connected());
    hear(record);
    hear(record);
    EXPECT_EQ(heard, Messages{answer});
    EXPECT_TRUE(speak());
}

TEST_P(AtAnOpensslServer, AnyOctetsInAHandshakeAreNoMoreThanAFailedOne) {
    Random random{2};
    for (int round = 0; round < 300; ++round) {
        client.connect();
        openssl_ends::Server other{
            "a", psk, [this](Bytes datagram) { to_client.push_back(copy(datagram)); }, GetParam()};
        for (int flight = 0; flight < 4; ++flight) {
            for (const Octets& datagram : std::exchange(to_server, {})) (void)other.open(datagram);
            for (Octets& datagram : std::exchange(to_client, {})) {
                if (random.below(2) == 0) {
                    datagram[random.below(static_cast<std::uint32_t>(datagram.size()))] ^=
                        static_cast<std::uint8_t>(1 + random.below(255));
                }
                hear(datagram);
            }
        }
        to_server.clear();
        to_client.clear();
    }
    EXPECT_TRUE(heard.empty());
    connect();
    EXPECT_TRUE(speak());
}

// --- a broker

using namespace broker_with_dtls;
using mqttsn::MsgType;

struct WithItsOwnRecords : testing::TestWithParam<ClientEnd::Wants> {
    Broker broker{1};
    OwnClient a{"a", key_a, ClientEnd::default_suites, GetParam()};
};
INSTANTIATE_TEST_SUITE_P(WithAnIdOfTheBrokerAndWithout, WithItsOwnRecords,
                         testing::Values(ClientEnd::Wants::connection_id, ClientEnd::Wants::none));

TEST_P(WithItsOwnRecords, AClientUsesNoNumberTwiceAlsoWhenTheLastFlightWasLost) {
    Numbers numbers;
    const auto take = [&](const Octets& datagram) {
        numbers.note(datagram);
        return broker.take(place, datagram);
    };
    a.end.connect();
    while (!a.outbox.empty()) {
        for (const Octets& datagram : std::exchange(a.outbox, {})) {
            const auto answers = take(datagram);
            if (broker.listener.clients().size() != 0) continue;  // the answer to Finished is lost
            for (const Sent& each : answers) a.hear(each.octets);
        }
    }
    ASSERT_FALSE(a.end.is_connected());
    wait_for_a_repetition(a.end, a.outbox);
    for (const Octets& datagram : std::exchange(a.outbox, {})) {
        for (const Sent& each : take(datagram)) a.hear(each.octets);
    }
    ASSERT_TRUE(a.end.is_connected());
    EXPECT_EQ(a.end.may_roam(), GetParam() == ClientEnd::Wants::connection_id);
    ASSERT_TRUE(a.end.seal(connect_as("a")));
    for (int n = 0; n < 100; ++n) ASSERT_TRUE(a.end.seal(ping));
    a.end.close();
    std::size_t answered = 0;
    for (const Octets& datagram : std::exchange(a.outbox, {})) answered += take(datagram).size();
    EXPECT_EQ(answered, 102U) << "CONNACK, PINGRESPs, close_notify: the broker took each";
    EXPECT_EQ(numbers.count(), 104U) << "and Finished twice";
}

TEST_P(WithItsOwnRecords, AClientThatBeginsAnewHasOtherKeys) {
    for (int round = 0; round < 3; ++round) {
        ASSERT_TRUE(a.connect(broker));
        ASSERT_EQ(a.ask(broker, connect_as("a")), MsgType::connack);
        EXPECT_EQ(a.ask(broker, ping), MsgType::pingresp);
    }
    EXPECT_EQ(broker.listener.handshakes().agreed(), 3U);
}

}  // namespace
}  // namespace romano::dtls::client_end_test
