// Who sends nonsense is named once in the trace, and a flood of them does not fill it.

#include "broker/daemon/bad_senders.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "tests/broker/daemon/captured_trace.h"

namespace romano::daemon::bad_senders_test {
namespace {

class NamingBadSenders : public testing::Test {
protected:
    void says_nonsense(std::uint16_t port) {
        const std::array<std::uint8_t, 2> octets{9, 9};
        const Endpoint from{
            .address = {127, 0, 0, 1}, .port = port, .family = Endpoint::Family::ipv4};
        senders_.look(++malformed_, from, octets);
    }
    [[nodiscard]] std::ptrdiff_t lines() const { return std::ranges::count(trace_.text(), '\n'); }

private:
    CapturedTrace trace_;
    BadSenders senders_;
    std::uint64_t malformed_ = 0;
};

TEST_F(NamingBadSenders, EachIsNamedOnce) {
    for (int i = 0; i < 3; ++i) says_nonsense(5000);
    EXPECT_EQ(lines(), 1);
    says_nonsense(5001);
    EXPECT_EQ(lines(), 2);
}

TEST_F(NamingBadSenders, AFloodFromEverNewPortsIsCountedOnlyFromSomePointOn) {
    for (std::uint16_t port = 1; port <= 5000; ++port) says_nonsense(port);
    EXPECT_EQ(lines(), 1001);  // the last one says so
}

}  // namespace
}  // namespace romano::daemon::bad_senders_test
