// Where a simulated robot stands after what it was told.
#include "firmware/posix/body.h"

#include <gtest/gtest.h>

namespace romano::firmware::body_test {
namespace {

romano_command command(std::uint16_t type, std::uint32_t amount) {
    romano_command out{.type = type, .size = 4, .arguments = {}};
    for (unsigned i = 0; i < 4; ++i) {
        out.arguments[i] = static_cast<std::uint8_t>(amount >> (24U - 8U * i));
    }
    return out;
}

void expect_pose(const Body& body, double x, double y, double heading) {
    EXPECT_NEAR(body.pose().x_mm, x, 1e-6);
    EXPECT_NEAR(body.pose().y_mm, y, 1e-6);
    EXPECT_NEAR(body.pose().heading_deg, heading, 1e-6);
}

TEST(Body, DrivesWhereItLooksAndSideways) {
    Body body;
    body.carry_out(command(0, 100));
    body.carry_out(command(2, 10));
    body.carry_out(command(4, 90'000));
    body.carry_out(command(0, 50));
    body.carry_out(command(3, 5));
    expect_pose(body, 105, 60, 90);
    body.carry_out(command(1, 60));
    body.carry_out(command(5, 180'000));
    expect_pose(body, 105, 0, -90);
}

TEST(Body, TellsItsLocationAsRomanoWantsIt) {
    Body body{{.x_mm = -1, .y_mm = 258, .heading_deg = 90}};
    const auto location = body.location();
    EXPECT_EQ(location[3], 0xFF);
    EXPECT_EQ(location[6], 1);
    EXPECT_EQ(location[7], 2);
    const auto pose = pose_of(location);
    ASSERT_TRUE(pose);
    expect_pose(Body{*pose}, -1, 258, 90);
    EXPECT_FALSE(pose_of(std::span{location}.first(11)));
}

TEST(Body, ACopiedPathHasTheSameShapeFromElsewhere) {
    Body leader;
    Body follower{{.x_mm = 1000, .y_mm = 0, .heading_deg = 90}};
    for (const auto& step : {command(0, 100), command(4, 90'000), command(0, 200)}) {
        const Pose before = leader.pose();
        leader.carry_out(step);
        follower.copy(before, leader.pose());
    }
    expect_pose(leader, 100, 200, 90);
    expect_pose(follower, 800, 100, 180);
}

TEST(Body, CommandsReadAsPeopleWriteThem) {
    EXPECT_EQ(to_text(command(0, 100)), "front 100 mm");
    EXPECT_EQ(to_text(command(5, 1500)), "rotate-right 1500 mdeg");
    EXPECT_EQ(to_text({.type = 0x8001, .size = 2, .arguments = {0x0A, 0x0B}}), "0x8001 0a0b");
}

}  // namespace
}  // namespace romano::firmware::body_test
