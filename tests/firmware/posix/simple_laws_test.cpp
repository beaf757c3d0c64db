// The laws by which simulated robots control each other.
#include "firmware/posix/simple_laws.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace romano::firmware::simple_laws_test {
namespace {

constexpr std::uint16_t follow = 1;
constexpr std::uint16_t go_to = 2;
using Octets = std::vector<std::uint8_t>;

Pose after(double seconds, const Leading& law, Pose plant, const Pose& own) {
    constexpr double period_s = 0.02;
    Body body{plant};
    for (double t = 0; t < seconds; t += period_s) {
        body.go_on(law.speed_for(body.pose(), own), period_s);
    }
    return body.pose();
}

TEST(SimpleLaws, TakeTheirOwnParametersOnly) {
    EXPECT_TRUE(Leading::parse(follow, Octets(4)));
    EXPECT_FALSE(Leading::parse(follow, Octets(8)));
    EXPECT_TRUE(Leading::parse(go_to, Octets(8)));
    EXPECT_FALSE(Leading::parse(go_to, Octets{}));
    EXPECT_FALSE(Leading::parse(3, Octets{}));
}

TEST(SimpleLaws, GoToEndsAtThePoint) {
    const auto law = Leading::parse(go_to, Octets{0, 0, 3, 232, 0xFF, 0xFF, 0xFF, 0});
    ASSERT_TRUE(law);
    const Pose end = after(20, *law, {.x_mm = -500, .y_mm = 100, .heading_deg = 120}, {});
    EXPECT_NEAR(end.x_mm, 1000, 5);
    EXPECT_NEAR(end.y_mm, -256, 5);
}

TEST(SimpleLaws, FollowKeepsItsDistanceFromBothSides) {
    const auto law = Leading::parse(follow, Octets{0, 0, 1, 44});  // 300 mm
    ASSERT_TRUE(law);
    const Pose leader{.x_mm = 700, .y_mm = 400, .heading_deg = 0};
    for (const double x : {-2000.0, 650.0}) {
        const Pose end = after(20, *law, {.x_mm = x, .y_mm = 400, .heading_deg = 0}, leader);
        EXPECT_NEAR(std::hypot(end.x_mm - leader.x_mm, end.y_mm - leader.y_mm), 300, 5);
    }
}

TEST(SimpleLaws, SpeedsAreBounded) {
    const auto law = Leading::parse(go_to, Octets{0x7F, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0});
    ASSERT_TRUE(law);
    EXPECT_LE(law->speed_for({}, {}).mm_s, 500);
    EXPECT_LE(law->speed_for({.heading_deg = 180}, {}).deg_s, 180);
}

TEST(SimpleLaws, SpeedsTravelAsRomanoSpeeds) {
    const auto octets = octets_of({.mm_s = -2, .deg_s = 0.258});
    EXPECT_EQ(Octets(octets.begin(), octets.end()), (Octets{0xFF, 0xFF, 0xFF, 0xFE, 0, 0, 1, 2}));
    const auto speed = speed_of(octets);
    ASSERT_TRUE(speed);
    EXPECT_EQ(speed->mm_s, -2);
    EXPECT_FALSE(speed_of(Octets(7)));
}

}  // namespace
}  // namespace romano::firmware::simple_laws_test
