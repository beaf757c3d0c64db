#include "overlay/radio/propagation.h"

#include <gtest/gtest.h>

namespace romano::radio::propagation_test {
namespace {

TEST(Propagation, LosesTheExponentTimesTenDbInTenTimesTheDistance) {
    const RadioModel model;
    EXPECT_DOUBLE_EQ(mean_dbm(model, 1), -40);
    EXPECT_DOUBLE_EQ(mean_dbm(model, 10), -67);
    EXPECT_DOUBLE_EQ(mean_dbm(model, 100), -94);
}

TEST(Propagation, OfPacketsAtTheEdgeHalfAreLostAndOneInFourJustAbove) {
    const RadioModel model;
    EXPECT_DOUBLE_EQ(reception_chance(model, model.half_lost_dbm), 0.5);
    EXPECT_NEAR(reception_chance(model, model.half_lost_dbm + model.lost_within_db), 0.75, 1e-9);
}

TEST(Propagation, ShadowingStaysWhileNobodyMoves) {
    RadioModel model;
    model.fading_db = 0;
    RadioLink link(model, 1);
    const double first = link.packet_dbm({0, 0}, {5, 0});
    EXPECT_DOUBLE_EQ(link.packet_dbm({0, 0}, {5, 0}), first);
    EXPECT_NE(link.packet_dbm({0, 0}, {6, 0}), first);
}

}  // namespace
}  // namespace romano::radio::propagation_test
