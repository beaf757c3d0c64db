// When a client of DTLS makes a handshake, and what becomes of its messages meanwhile: a link, and
// the broker at its other end.

#include "romano/dtls/client_link.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "romano/mqttsn/decode.h"
#include "tests/broker/dtls/broker_with_dtls.h"

namespace romano::dtls::client_link_test {
namespace {

using namespace broker_with_dtls;
using mqttsn::MsgType;

struct ALink : testing::Test {
    /// Hands on what waits, to and fro, until nobody has anything to say.
    void exchange(Broker& with) {
        while (!outbox.empty()) {
            for (const Octets& datagram : std::exchange(outbox, {})) {
                for (const Sent& answer : with.take(place, datagram)) hear(answer.octets);
            }
        }
    }
    void hear(const Octets& datagram) {
        const Bytes message = link.open(datagram);
        const auto frame = mqttsn::decode_frame(message);
        if (frame) heard.push_back(frame->type);
    }
    bool asks(Broker& of, const Octets& message, MsgType answer) {
        heard.clear();
        link.send(message);
        exchange(of);
        return heard == std::vector{answer};
    }
    bool connects(Broker& to) { return asks(to, connect_as("a"), MsgType::connack); }
    bool is_answered(Broker& by) { return asks(by, ping, MsgType::pingresp); }

    Broker broker{1};
    std::vector<Octets> outbox;
    std::vector<MsgType> heard;
    ClientLink link{"a", protection::pre_shared_key(key_a), [this](Bytes datagram) {
                        outbox.emplace_back(datagram.begin(), datagram.end());
                    }};
};

TEST_F(ALink, MakesAHandshakeForItsFirstMessageWhichWaits) {
    EXPECT_FALSE(link.due_in()) << "nothing is to be repeated yet";
    ASSERT_TRUE(connects(broker));
    EXPECT_EQ(link.handshakes(), 1U);
    EXPECT_TRUE(is_answered(broker));
    EXPECT_EQ(link.handshakes(), 1U) << "and none for the next";
}

TEST_F(ALink, NeedsTheTimeWhileAHandshakeGoesOnAndNotAfterIt) {
    link.send(connect_as("a"));
    EXPECT_TRUE(link.due_in());
    exchange(broker);
    EXPECT_FALSE(link.due_in());
}

TEST_F(ALink, KeepsTheNewestOfWhatWaits) {
    constexpr std::size_t too_many = ClientLink::most_waiting + 3;
    for (std::uint8_t n = 0; n < too_many; ++n)
        link.send(Octets{4, 0x18, 0, n});  // DISCONNECT for n s
    exchange(broker);
    ASSERT_EQ(broker.delivered.size(), ClientLink::most_waiting);
    EXPECT_EQ(broker.delivered.front().back(), 3);
    EXPECT_EQ(broker.delivered.back().back(), too_many - 1);
}

TEST_F(ALink, ForgetsAtAConnectWhatWaited) {
    link.send(ping);
    link.send(connect_as("a"));
    exchange(broker);
    EXPECT_EQ(heard, std::vector{MsgType::connack});
}

TEST_F(ALink, MakesANewOneForAConnectAfterTheBrokerWasHeard) {
    ASSERT_TRUE(connects(broker));
    EXPECT_TRUE(connects(broker));
    EXPECT_EQ(link.handshakes(), 2U);
}

TEST_F(ALink, MakesNoneForAConnectWhoseAnswerWasLost) {
    link.send(connect_as("a"));
    while (!link.is_connected()) {  // and the CONNECT leaves
        for (const Octets& datagram : std::exchange(outbox, {})) {
            for (const Sent& answer : broker.take(place, datagram)) hear(answer.octets);
        }
    }
    for (const Octets& datagram : std::exchange(outbox, {})) (void)broker.take(place, datagram);
    ASSERT_TRUE(heard.empty());
    EXPECT_TRUE(connects(broker));
    EXPECT_EQ(link.handshakes(), 1U);
}

TEST_F(ALink, LeavesABrokerBehindThatHasLostTheAssociation) {
    ASSERT_TRUE(connects(broker));
    Broker another{1};
    EXPECT_FALSE(is_answered(another));
    EXPECT_TRUE(connects(another));
    EXPECT_TRUE(is_answered(another));
    EXPECT_EQ(link.handshakes(), 2U);
}

TEST_F(ALink, DoesNotHurryASlowBrokerAndLeavesOneBehindThatDiedInAHandshake) {
    link.send(connect_as("a"));
    ASSERT_EQ(std::exchange(outbox, {}).size(), 1U) << "ClientHello";
    link.send(connect_as("a"));
    EXPECT_TRUE(outbox.empty());
    EXPECT_EQ(link.handshakes(), 1U);
    EXPECT_TRUE(connects(broker));
    EXPECT_EQ(link.handshakes(), 2U);
}

TEST_F(ALink, BeginsAnewAfterAForgedAlertBrokeItsHandshakeOff) {
    link.send(ping);
    outbox.clear();
    hear({21, 0xFE, 0xFD, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 2, 40});  // fatal: handshake failure
    EXPECT_FALSE(link.due_in());
    EXPECT_TRUE(connects(broker));
    EXPECT_EQ(link.handshakes(), 2U);
}

TEST_F(ALink, GoesOnAfterForgeriesWhenItIsConnected) {
    ASSERT_TRUE(connects(broker));
    hear({21, 0xFE, 0xFD, 0, 0, 0, 0, 0, 0, 0, 9, 0, 2, 2, 40});
    hear({21, 0xFE, 0xFD, 0, 1, 0, 0, 0, 0, 0, 9, 0, 2, 2, 40});
    hear({23, 0xFE, 0xFD, 0, 1, 0, 0, 0, 0, 0, 9, 0, 3, 1, 2, 3});
    hear(Octets(1500, 0xFF));
    EXPECT_TRUE(is_answered(broker));
    EXPECT_EQ(link.handshakes(), 1U);
}

TEST_F(ALink, SpeaksToAnHeirWithoutAHandshake) {
    ASSERT_TRUE(connects(broker));
    Broker heir{2};
    heir.hear(broker);
    heir.adopt(broker, "a");
    EXPECT_TRUE(is_answered(heir));
    EXPECT_EQ(link.handshakes(), 1U);
}

TEST_F(ALink, SaysGoodbye) {
    ASSERT_TRUE(connects(broker));
    ASSERT_EQ(broker.listener.clients().size(), 1U);
    link.close();
    exchange(broker);
    EXPECT_EQ(broker.listener.clients().size(), 0U);
}

}  // namespace
}  // namespace romano::dtls::client_link_test
