// When the memory of handshakes is given back.

#include "broker/daemon/handshake_memory.h"

#include <gtest/gtest.h>

namespace romano::daemon::handshake_memory_test {
namespace {

using namespace std::chrono_literals;

struct MemoryOfHandshakes : testing::Test {
    /// True when it was given back.
    bool at(std::chrono::seconds time, std::size_t going_on, std::uint64_t ended) {
        const int before = given_back;
        memory.on_time(Instant{} + Duration{time}, going_on, ended);
        return given_back != before;
    }
    int given_back = 0;
    HandshakeMemory memory{[this] { ++given_back; }};
};

TEST_F(MemoryOfHandshakes, IsGivenBackOnceWhenAllHaveEnded) {
    EXPECT_FALSE(at(1s, 0, 0)) << "there were none";
    EXPECT_FALSE(at(2s, 3, 5)) << "some go on";
    EXPECT_TRUE(at(3s, 0, 8));
    EXPECT_FALSE(at(60s, 0, 8)) << "there were none since";
    EXPECT_TRUE(at(61s, 0, 9));
}

TEST_F(MemoryOfHandshakes, IsGivenBackSeldomWhereHandshakesComeOneByOne) {
    int times = 0;
    for (int second = 1; second <= 100; ++second) {
        times += at(std::chrono::seconds{second}, 0, static_cast<std::uint64_t>(second)) ? 1 : 0;
    }
    EXPECT_EQ(times, 10);
}

TEST_F(MemoryOfHandshakes, OfTheLastOnesIsGivenBackWhenItIsTime) {
    EXPECT_TRUE(at(1s, 0, 1));
    EXPECT_FALSE(at(2s, 0, 2));
    EXPECT_TRUE(at(11s, 0, 2));
}

}  // namespace
}  // namespace romano::daemon::handshake_memory_test
