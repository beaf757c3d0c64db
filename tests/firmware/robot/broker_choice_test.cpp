// Which broker a robot talks to.
#include "firmware/robot/broker_choice.h"

#include <gtest/gtest.h>

#include <array>

#include "romano/mqttsn/codec.h"

namespace romano::firmware::broker_choice_test {
namespace {

using namespace std::chrono_literals;

Endpoint broker(std::uint8_t host) {
    return {.address = {10, 0, 0, host}, .port = 1883, .family = Endpoint::Family::ipv4};
}

class Choosing : public testing::Test {
protected:
    /// The gateway's answer to a search.
    void answers(std::uint8_t host, std::optional<int> dbm = {}) {
        std::array<std::uint8_t, 8> octets{};
        const std::size_t size =
            mqttsn::encode(mqttsn::Gwinfo{.gateway_id = host, .gateway_address = {}}, octets);
        choice.on_datagram(now, broker(host), Bytes{octets}.first(size), dbm);
    }
    /// Until it asks.
    void asks() {
        std::array<std::uint8_t, BrokerChoice::largest_datagram> octets{};
        for (int i = 0; i < 20'000; ++i, now += 1ms) {
            if (choice.on_tick(now, octets) != 0) return;
        }
        FAIL() << "it never asks";
    }

    Instant now{1s};
    BrokerChoice choice{1};
};

TEST_F(Choosing, AsksUntilABrokerAnswers) {
    choice.search(now);
    asks();
    EXPECT_FALSE(choice.choose(now, {}));
    asks();
    answers(1);
    now += BrokerChoice::answers_within;
    EXPECT_EQ(choice.choose(now, {}), broker(1));
}

TEST_F(Choosing, WaitsALittleForFurtherAnswers) {
    choice.search(now);
    asks();
    answers(1, -80);
    EXPECT_FALSE(choice.choose(now, {}));
    now += 100ms;
    answers(2, -50);
    now += BrokerChoice::answers_within;
    EXPECT_EQ(choice.choose(now, {}), broker(2)) << "the stronger one";
}

TEST_F(Choosing, WithoutSignalStrengthTheQuickestAnswerIsNearest) {
    choice.search(now);
    asks();
    now += 5ms;
    answers(1);
    now += 40ms;
    answers(2);
    now += BrokerChoice::answers_within;
    EXPECT_EQ(choice.choose(now, {}), broker(1));
}

TEST_F(Choosing, LeavesABrokerOnlyForAClearlyBetterOne) {
    choice.search(now);
    asks();
    answers(1, -60);
    answers(2, -56);
    now += BrokerChoice::answers_within;
    EXPECT_EQ(choice.choose(now, broker(1)), broker(1));
    asks();
    answers(2, -54);
    now += BrokerChoice::answers_within;
    EXPECT_EQ(choice.choose(now, broker(1)), broker(2));
    EXPECT_EQ(choice.choose(now, broker(2)), broker(2)) << "and does not swing back";
}

TEST_F(Choosing, MovesOnceWhenTheAnswersToItsSearchAreIn) {
    choice.search(now);
    asks();
    answers(1, -60);
    now += BrokerChoice::answers_within;
    asks();
    answers(1, -80);
    answers(3, -70);
    EXPECT_EQ(choice.choose(now, broker(1)), broker(1)) << "somebody nearer may answer yet";
    answers(2, -50);
    EXPECT_EQ(choice.choose(now, broker(1)), broker(1));
    EXPECT_EQ(choice.decides_at(), now + BrokerChoice::answers_within);
    now = choice.decides_at();
    EXPECT_EQ(choice.choose(now, broker(1)), broker(2));
}

TEST_F(Choosing, ABrokerThatDoesNotAnswerAnyMoreIsAbandoned) {
    choice.search(now);
    asks();
    answers(1, -40);
    answers(2, -70);
    now += 1s;
    choice.abandon(now, broker(1));
    EXPECT_EQ(choice.choose(now, {}), broker(2));
}

TEST_F(Choosing, KeepsTheBrokerThatNobodyTellsOf) {
    choice.search(now);
    asks();
    answers(2, -70);
    now += 1s;
    EXPECT_EQ(choice.choose(now, broker(1)), broker(1));
}

TEST_F(Choosing, OtherDatagramsAreNoAnswers) {
    choice.search(now);
    asks();
    const std::array<std::uint8_t, 3> connack{3, 0x05, 0};
    choice.on_datagram(now, broker(1), connack, -40);
    now += 1s;
    EXPECT_FALSE(choice.choose(now, {}));
}

TEST_F(Choosing, ABrokerThatAnswersNoSearchAnyMoreIsForgotten) {
    choice.search(now);
    asks();
    answers(1, -50);
    answers(2, -70);
    now += BrokerChoice::answers_within;
    EXPECT_EQ(choice.choose(now, broker(2)), broker(1));
    for (int searches = 0; searches < 2; ++searches) {  // the robot drives out of 1's cell
        choice.search(now);
        asks();
        answers(2, -70);
        now += 1s;
    }
    choice.search(now);
    EXPECT_EQ(choice.choose(now, broker(2)), broker(2));
}

TEST_F(Choosing, LooksAroundWhenItsBrokerGetsWeaker) {
    choice.search(now);
    asks();
    answers(1, -50);
    now += 2s;
    answers(1, -50 - BrokerChoice::weaker_db + 1);
    EXPECT_GT(choice.next_wakeup(), now + BrokerChoice::looks_around_within);
    answers(1, -50 - BrokerChoice::weaker_db);
    EXPECT_LE(choice.next_wakeup(), now + BrokerChoice::looks_around_within);
}

}  // namespace
}  // namespace romano::firmware::broker_choice_test
