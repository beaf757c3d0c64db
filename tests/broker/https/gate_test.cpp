#include "broker/https/gate.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/https_files.h"

namespace romano::https::gate_test {
namespace {

using namespace std::chrono_literals;

struct AGate : testing::Test {
    tests::HttpsFiles files;
    Gate gate{{files.certificate(), files.token()}};
    Gate::Time now{1h};

    static Gate::Address address(unsigned n) {
        return boost::asio::ip::address_v4(0x0A000000U + n);
    }
    bool begins(unsigned from) { return gate.begins_handshake(address(from), now); }
};

TEST_F(AGate, LetsSoManyHandshakesBeAtOnce) {
    for (unsigned n = 0; n < Gate::most_handshakes; ++n) {
        EXPECT_TRUE(begins(n)) << n;
        now += 1s;
    }
    EXPECT_FALSE(begins(99));
    gate.ends_handshake(address(0), false);
    EXPECT_TRUE(begins(99));
    EXPECT_EQ(gate.counts().handshakes_failed, 1U);
}

TEST_F(AGate, LetsSoManyHandshakesBeginInASecond) {
    for (unsigned n = 0; n < Gate::most_in_a_second; ++n) {
        EXPECT_TRUE(begins(n)) << n;
        gate.ends_handshake(address(n), true);
        now += 10ms;
    }
    EXPECT_FALSE(begins(99));
    now = Gate::Time{1h} + 1s;  // the first one is that long ago
    EXPECT_TRUE(begins(99));
    EXPECT_FALSE(begins(98));
}

TEST_F(AGate, LeavesRoomBesideAnAddressThatBeginsAgainAndAgain) {
    for (unsigned n = 0; n < Gate::most_in_a_second / 2; ++n) {
        EXPECT_TRUE(begins(1));
        gate.ends_handshake(address(1), false);
    }
    EXPECT_FALSE(begins(1));
    EXPECT_TRUE(begins(2));
    now += 1s;
    EXPECT_TRUE(begins(1));
}

TEST_F(AGate, LeavesRoomBesideAnAddressThatNeverEndsItsHandshakes) {
    for (unsigned n = 0; n < Gate::most_handshakes / 2; ++n) {
        EXPECT_TRUE(begins(1));
        now += 1s;
    }
    EXPECT_FALSE(begins(1));
    EXPECT_TRUE(begins(2));
    gate.ends_handshake(address(1), false);
    EXPECT_TRUE(begins(1));
}

TEST_F(AGate, CountsWhoShowsNoTokenOrAWrongOne) {
    EXPECT_TRUE(gate.lets_in(std::string{"Bearer "} + tests::HttpsFiles::word, address(1)));
    EXPECT_FALSE(gate.lets_in("Bearer another", address(2)));
    EXPECT_FALSE(gate.lets_in("", address(3)));
    EXPECT_EQ(gate.counts().wrong_tokens, 1U);
    EXPECT_EQ(gate.counts().without_token, 1U);
    EXPECT_EQ(gate.last_wrong(), address(2));
}

}  // namespace
}  // namespace romano::https::gate_test
