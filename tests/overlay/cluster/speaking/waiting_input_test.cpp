#include "overlay/cluster/speaking/waiting_input.h"

#include <gmock/gmock.h>

#include "romano/base/bytes.h"
#include "tests/overlay/cluster/events.h"

namespace romano::cluster::waiting_input_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const Endpoint here = test::address(1);
const Endpoint elsewhere = test::address(2);

struct Input {
    WaitingInput waiting;

    void hold(std::string_view text, const Endpoint& via = here) {
        waiting.hold(via, test::address(9), as_octets(text), true);
    }
    /// What came by `elsewhere` must wait on.
    std::vector<std::string> take(std::size_t most) {
        const auto must_wait = [](const auto& datagram) { return datagram.via == elsewhere; };
        std::vector<std::string> texts;
        for (const auto& datagram : waiting.take_unless(must_wait, most)) {
            texts.emplace_back(as_text(datagram.octets));
        }
        return texts;
    }
};

TEST(WaitingInput, I8_SoManyAreTakenAtATimeAndTheOthersAreNotForgotten) {
    Input input;
    for (const auto* text : {"first", "second", "third"}) input.hold(text);
    EXPECT_THAT(input.take(2), ElementsAre("first", "second"));
    EXPECT_TRUE(input.waiting.is_behind());
    EXPECT_TRUE(input.waiting.holds(test::address(9)));
    EXPECT_THAT(input.take(2), ElementsAre("third"));
    EXPECT_FALSE(input.waiting.is_behind());
    EXPECT_FALSE(input.waiting.holds(test::address(9)));
}

TEST(WaitingInput, IsNotBehindWithWhatMustWaitOn) {
    Input input;
    for (const auto* text : {"first", "second"}) input.hold(text, elsewhere);
    input.hold("third");
    EXPECT_THAT(input.take(1), ElementsAre("third"));
    EXPECT_FALSE(input.waiting.is_behind());
    EXPECT_EQ(input.waiting.size(), 2U);
}

// The cluster has to ask first whose client that is.
TEST(WaitingInput, P3_WhatIsPutBackStaysBeforeWhatCameSince) {
    Input input;
    for (const auto* text : {"first", "second", "third"}) input.hold(text);
    input.waiting.put_back(input.waiting.take_unless([](const auto&) { return false; }, 2));
    EXPECT_EQ(input.waiting.size(), 3U);
    EXPECT_TRUE(input.waiting.holds(test::address(9)));
    EXPECT_THAT(input.take(9), ElementsAre("first", "second", "third"));
    EXPECT_FALSE(input.waiting.holds(test::address(9)));
}

TEST(WaitingInput, IsNotBehindWithWhatIsDropped) {
    Input input;
    for (const auto* text : {"first", "second"}) input.hold(text);
    EXPECT_THAT(input.take(0), IsEmpty());
    ASSERT_TRUE(input.waiting.is_behind());
    input.waiting.drop(here);
    EXPECT_FALSE(input.waiting.is_behind());
}

}  // namespace
}  // namespace romano::cluster::waiting_input_test
