// When a cell between real processes refuses to report.
#include <gtest/gtest.h>

#include "experiments/air/radio_bridge.h"

namespace romano::experiments::radio_bridge_figures_test {
namespace {

TEST(RadioBridgeFigures, MoreThanOneLateDatagramInAHundredIsALag) {
    RadioBridgeFigures figures;
    EXPECT_FALSE(figures.has_lagged()) << "nothing was handed over";
    for (int i = 0; i < 100; ++i) figures.lag.add(Duration{1});
    figures.late = 1;
    EXPECT_FALSE(figures.has_lagged());
    figures.late = 2;
    EXPECT_TRUE(figures.has_lagged());
}

}  // namespace
}  // namespace romano::experiments::radio_bridge_figures_test
