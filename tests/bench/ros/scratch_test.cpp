#include "bench/ros/scratch.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include "tests/temporary_folder.h"

namespace romano::bench::ros::scratch_test {
namespace {

TEST(Scratch, IsGoneWithAllThatIsInItWhenItsOwnerFails) {
    const tests::TemporaryFolder around;
    const std::filesystem::path folder = around / "scratch";
    try {
        const Scratch scratch(folder);
        std::filesystem::create_directories(folder / "deep");
        std::ofstream(folder / "deep" / "file") << "something";
        ASSERT_TRUE(std::filesystem::exists(folder / "deep" / "file"));
        throw std::runtime_error("a run failed");
    } catch (const std::runtime_error&) {
    }
    EXPECT_FALSE(std::filesystem::exists(folder));
}

}  // namespace
}  // namespace romano::bench::ros::scratch_test
