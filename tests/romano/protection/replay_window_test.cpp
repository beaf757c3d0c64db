// Which numbers count as having been there, at the window's edges; as RFC 4303 section 3.4.3.

#include "romano/protection/replay_window.h"

#include <gtest/gtest.h>

#include <set>

#include "romano/base/random.h"
#include "romano/protection/reserve.h"

namespace romano::protection {
namespace {

TEST(ReplayWindow, KnowsNothingAtFirst) {
    const ReplayWindow window;
    EXPECT_FALSE(window.has_seen(0));
    EXPECT_FALSE(window.has_seen(max_number - 1));
}

TEST(ReplayWindow, HasSeenWhatWasNoted) {
    ReplayWindow window;
    window.note(0);
    EXPECT_TRUE(window.has_seen(0));
    EXPECT_FALSE(window.has_seen(1));
    window.note(max_number - 1);
    EXPECT_TRUE(window.has_seen(max_number - 1));
    EXPECT_FALSE(window.has_seen(max_number - 2));
}

TEST(ReplayWindow, TellsLateNumbersApartForItsWidth) {
    ReplayWindow window;
    window.note(100);
    for (std::uint32_t age = 1; age < ReplayWindow::width; ++age) {
        EXPECT_FALSE(window.has_seen(100 - age)) << age;
    }
    EXPECT_TRUE(window.has_seen(100 - ReplayWindow::width));
    EXPECT_TRUE(window.has_seen(0));
    const std::uint32_t oldest = 100 - ReplayWindow::width + 1;
    window.note(oldest);
    EXPECT_TRUE(window.has_seen(oldest));
    EXPECT_FALSE(window.has_seen(oldest + 1));
}

TEST(ReplayWindow, ForgetsNothingWhenItMovesOnByItsWidthOrMore) {
    for (const std::uint32_t steps :
         {ReplayWindow::width - 1, ReplayWindow::width, ReplayWindow::width + 1}) {
        ReplayWindow window;
        window.note(50);
        window.note(50 + steps);
        EXPECT_TRUE(window.has_seen(50)) << steps;
        EXPECT_TRUE(window.has_seen(50 + steps)) << steps;
        EXPECT_FALSE(window.has_seen(50 + steps - 1)) << steps;
    }
}

TEST(ReplayWindow, HasSeenAllBelowItsFloor) {
    const ReplayWindow window{1000};
    EXPECT_TRUE(window.has_seen(999));
    EXPECT_TRUE(window.has_seen(0));
    EXPECT_FALSE(window.has_seen(1000));
}

TEST(ReplayWindow, NeverTakesANumberTwiceInAnyOrder) {
    Random random{20};
    for (int run = 0; run < 200; ++run) {
        ReplayWindow window;
        std::set<std::uint32_t> noted;
        std::uint32_t base = 0;
        for (int i = 0; i < 500; ++i) {
            base += random.below(3);
            const std::uint32_t number = base + random.below(80);
            if (window.has_seen(number)) continue;
            ASSERT_TRUE(noted.insert(number).second) << number;
            window.note(number);
        }
    }
}

}  // namespace
}  // namespace romano::protection
