// What runs leave is what the report reads, and its verdict is what the numbers say.
#include "bench/ros/ros_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "bench/ros/client_sizes.h"
#include "bench/ros/samples.h"
#include "tests/temporary_folder.h"

namespace romano::bench::ros::ros_report_test {
namespace {

TEST(Samples, AreReadAsTheyWereWritten) {
    const tests::TemporaryFolder folder;
    const auto file = folder.path() / "a.samples";
    write_samples({{1, 2, 3, 4}, {5, 6, 7, 0}}, file);
    const auto samples = read_samples(file);
    ASSERT_EQ(samples.size(), 2U);
    EXPECT_EQ(samples[1].publisher, 5U);
    EXPECT_EQ(samples[0].heard_ns, 4);
    EXPECT_TRUE(read_samples(folder.path() / "none").empty());
}

TEST(Figures, AreReadAsTheyWereWritten) {
    Figures figures;
    figures.set("delay_ms", 0.125);
    figures.set("none", std::optional<double>{});
    const Figures read = figures_in(to_csv(figures));
    EXPECT_EQ(read.get("delay_ms"), 0.125);
    EXPECT_FALSE(read.get("none"));
}

class Verdict : public testing::Test {
protected:
    Verdict() {
        plan.parts = {"delay"};
        plan.contestants = all_contestants();
    }
    void give(const std::string& contestant, double p50_ms) {
        Figures figures;
        figures.set("one_way_p50_ms", p50_ms);
        results.add(contestant, "delay_100_32", figures);
    }
    [[nodiscard]] std::string words() const {
        const auto sections = sections_of(plan, results);
        return sections.front().tables.front().table.rows.at(0).back();
    }

    Plan plan;
    Results results;
};

TEST_F(Verdict, SaysWhereRosIsBetter) {
    give("ros2_cyclone", 0.1);
    give("ros1", 0.3);
    give("romano_1", 0.2);
    EXPECT_EQ(words(), "ROS is better, 2.00 times");
}

TEST_F(Verdict, SaysWhereItIsNot) {
    give("ros2_cyclone", 0.6);
    give("romano_1", 0.4);
    give("romano_3", 0.2);
    EXPECT_EQ(words(), "ROMANO is better, 3.00 times");
}

TEST_F(Verdict, TakesSmallDifferencesForNone) {
    give("ros1", 0.21);
    give("romano_5", 0.2);
    EXPECT_EQ(words(), "about the same");
}

TEST_F(Verdict, LooksAtTheReliableOfTheTwoAlone) {
    give("mosquitto", 0.01);
    give("ros2_fastdds_best_effort", 0.01);
    give("ros1", 0.1);
    give("romano_1", 0.2);
    EXPECT_EQ(words(), "ROS is better, 2.00 times");
}

TEST_F(Verdict, LeavesOutWhoLostMessages) {
    give("ros1", 0.1);
    give("romano_1", 0.2);
    Figures figures;
    figures.set("one_way_p50_ms", 0.05);
    figures.set("messages", 1000);
    figures.set("lost", 11);
    results.add("romano_3", "delay_100_32", figures);
    EXPECT_EQ(words(), "ROS is better, 2.00 times");
}

/// The numbers of a table that somebody typed in were those of an older client.
TEST(SmallestClient, IsAsLargeAsTheImageOfThisBuild) {
    const auto sections = sections_of(Plan{}, Results{});
    const auto found =
        std::ranges::find(sections, "The smallest client", &experiments::Section::title);
    ASSERT_NE(found, sections.end());
    const auto& client = found->tables.front().table.rows.front();
    if (!size_of_client) {
        EXPECT_EQ(client.at(1), "–");
        EXPECT_EQ(client.at(3), "not built: there is no arm-none-eabi-g++");
        return;
    }
    std::string flash = client.at(1);
    std::erase(flash, ',');
    EXPECT_EQ(flash, std::to_string(size_of_client->flash_octets));
    EXPECT_GT(size_of_client->flash_octets, 1'000);
    EXPECT_GT(size_of_client->ram_octets, 500);
}

TEST(Tasks, AreNotDoneByWhomTheyDoNotConcern) {
    Plan plan;
    plan.parts = {"deaths"};
    const auto tasks = tasks_of(plan);
    for (const Contestant& one : all_contestants()) {
        const bool has_middle = one.brokers > 0;
        EXPECT_EQ(takes_part(one, tasks.at(0)), has_middle) << one.full_name();
        EXPECT_EQ(takes_part(one, tasks.at(1)), one.reliable) << one.full_name();
    }
}

}  // namespace
}  // namespace romano::bench::ros::ros_report_test
