#include "overlay/cluster/speaking/held_output.h"

#include <gmock/gmock.h>

#include <string_view>

namespace romano::cluster::held_output_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Endpoint via(std::uint16_t port) {
    Endpoint endpoint{};
    endpoint.port = port;
    return endpoint;
}

struct Output {
    HeldOutput held;

    void hold(broker::Seq after, std::string_view text, std::uint16_t port = 1,
              std::string_view client = {}) {
        held.hold({.via = via(port), .to = {{}, std::string(client)}, .after = after},
                  as_octets(text));
    }
    std::vector<std::string> release(broker::Seq safe,
                                     HeldOutput::Fate of_port_2 = HeldOutput::Fate::leaves,
                                     std::size_t most = 1000) {
        broker::Actions out;
        held.release(
            safe,
            [&](const Endpoint& from) {
                return from == via(2) ? of_port_2 : HeldOutput::Fate::leaves;
            },
            most, out);
        std::vector<std::string> texts;
        for (const auto& action : out.list()) {
            texts.emplace_back(as_text(out.octets(std::get<broker::Send>(action))));
        }
        return texts;
    }
};

TEST(HeldOutput, LeavesWhenItsPositionIsSafe) {
    Output output;
    output.hold(3, "three");
    output.hold(5, "five");
    EXPECT_THAT(output.release(2), IsEmpty());
    EXPECT_THAT(output.release(4), ElementsAre("three"));
    EXPECT_THAT(output.release(9), ElementsAre("five"));
    EXPECT_TRUE(output.held.empty());
}

TEST(HeldOutput, TellsWhatWouldGoFirst) {
    Output output;
    output.hold(3, "three");
    EXPECT_FALSE(output.held.holds_any_through(2));
    EXPECT_TRUE(output.held.holds_any_through(3));
    (void)output.release(3);
    EXPECT_FALSE(output.held.holds_any_through(3));
}

TEST(HeldOutput, KeepsTheOrderWithinOnePosition) {
    Output output;
    output.hold(3, "first");
    output.hold(3, "second");
    EXPECT_THAT(output.release(3), ElementsAre("first", "second"));
}

// P3: a client that roamed to the heir has answered the PUBLISH that waits for its former address,
// and would take it for a new one behind the PUBREL.
TEST(HeldOutput, NothingOvertakesWhatWaitsForItsAddress) {
    Output output;
    output.hold(3, "publish", 2, "robot");
    output.hold(4, "pubrel", 1, "robot");
    output.hold(4, "other's", 1, "other");
    EXPECT_THAT(output.release(4, HeldOutput::Fate::waits), ElementsAre("other's"));
    EXPECT_TRUE(output.held.detains({{}, "robot"}));
    EXPECT_FALSE(output.held.detains({{}, "other"}));
    EXPECT_THAT(output.release(4), ElementsAre("publish", "pubrel"));
    EXPECT_FALSE(output.held.detains({{}, "robot"}));
}

TEST(HeldOutput, WaitsForItsAddress) {
    Output output;
    output.hold(1, "elsewhere", 2);
    output.hold(2, "here", 1, "other");
    EXPECT_THAT(output.release(9, HeldOutput::Fate::waits), ElementsAre("here"));
    EXPECT_THAT(output.release(9), ElementsAre("elsewhere"));
}

TEST(HeldOutput, IsDroppedWithItsAddress) {
    Output output;
    output.hold(1, "stale", 2);
    EXPECT_THAT(output.release(9, HeldOutput::Fate::is_dropped), IsEmpty());
    EXPECT_TRUE(output.held.empty());
}

TEST(HeldOutput, I8_SoManyLeaveAtATimeAndTheOthersAreNotForgotten) {
    Output output;
    for (const auto* text : {"first", "second", "third"}) output.hold(3, text);
    output.hold(4, "not yet safe");
    EXPECT_THAT(output.release(3, HeldOutput::Fate::leaves, 2), ElementsAre("first", "second"));
    EXPECT_TRUE(output.held.is_behind());
    EXPECT_THAT(output.release(3, HeldOutput::Fate::leaves, 2), ElementsAre("third"));
    EXPECT_FALSE(output.held.is_behind());
}

TEST(HeldOutput, IsNotBehindWithWhatWaitsForItsAddress) {
    Output output;
    output.hold(3, "here");
    output.hold(3, "elsewhere", 2);
    (void)output.release(3, HeldOutput::Fate::waits, 2);
    EXPECT_FALSE(output.held.is_behind());
}

TEST(HeldOutput, P8_BeyondItsBoundNewDatagramsAreDropped) {
    Output output;
    const std::string large(1U << 20U, 'x');
    for (int i = 0; i < 100; ++i) output.hold(1, large);
    EXPECT_GT(output.held.dropped(), 0U);
    EXPECT_LT(output.release(1).size(), 100U);
}

}  // namespace
}  // namespace romano::cluster::held_output_test
