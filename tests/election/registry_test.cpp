#include <gmock/gmock.h>

#include "election/elector.h"
#include "election/failure_detector.h"

namespace romano::election::registry_test {
namespace {

using namespace std::chrono_literals;

TEST(Registry, EveryNameOfAnElectorMakesOne) {
    for (const auto name : elector_names()) {
        EXPECT_NE(make_elector(name, {.detection_time = 100ms}), nullptr) << name;
    }
    EXPECT_THAT(elector_names(), testing::Contains("component"));
}

TEST(Registry, EveryNameOfADetectorMakesOne) {
    for (const auto name : detector_names()) {
        EXPECT_NE(make_detector(name, {.beacon_every = 10ms, .timeout = 100ms}), nullptr) << name;
    }
    EXPECT_THAT(detector_names(), testing::Contains("fixed"));
}

TEST(Registry, AnUnknownNameMakesNothing) {
    EXPECT_EQ(make_elector("dictator", {}), nullptr);
    EXPECT_EQ(make_detector("crystal-ball", {}), nullptr);
}

}  // namespace
}  // namespace romano::election::registry_test
