#include "experiments/applications/path_error.h"

#include <gtest/gtest.h>

namespace romano::experiments::path_error_test {
namespace {

using Path = std::vector<firmware::Pose>;

TEST(PathError, IsNoneForTheSamePathFromAnotherPlaceAndHeading) {
    const Path path{{0, 0, 0}, {100, 0, 0}, {100, 50, 90}};
    const Path copy{{500, 500, 90}, {500, 600, 90}, {450, 600, 180}};
    EXPECT_NEAR(path_error(path, copy).most_mm, 0, 1e-9);
}

TEST(PathError, IsTheDistanceToTheNearestPlaceOfThePath) {
    const Path path{{0, 0, 0}, {100, 0, 0}};
    const Path copy{{0, 0, 0}, {50, 3, 0}, {104, 0, 0}};
    const PathError error = path_error(path, copy);
    EXPECT_NEAR(error.most_mm, 4, 1e-9);
    EXPECT_NEAR(error.mean_mm, 7.0 / 3, 1e-9);
}

TEST(PathError, ARobotThatStoodStillHasAPathOfNoLength) {
    EXPECT_EQ(length_mm({{7, 7, 0}}), 0);
    EXPECT_EQ(path_error({{7, 7, 0}}, {{0, 0, 0}, {0, 5, 0}}).most_mm, 5);
}

}  // namespace
}  // namespace romano::experiments::path_error_test
