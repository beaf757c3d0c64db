#include "bench/failover/trace_tail.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/temporary_folder.h"

namespace romano::bench::trace_tail_test {
namespace {

using namespace std::chrono_literals;

TEST(TraceLine, HasTheMonotonicClockAndTheText) {
    const auto line = parse_trace_line("2026-01-02 10:20:30.123 [4711.250000] info: lost b2");
    ASSERT_TRUE(line.at);
    EXPECT_EQ(line.at->time_since_epoch(), 4711250ms);
    EXPECT_EQ(line.text, "lost b2");
}

TEST(TraceLine, AnyOtherLineIsTextAlone) {
    for (const char* line : {"", "romano-broker b1: serving 127.0.0.1:1883 (domain 7 on lo)",
                             "[not a number] info: x", "[", "] : [", "[1.5", "[1.5] no colon"}) {
        const auto parsed = parse_trace_line(line);
        EXPECT_FALSE(parsed.at) << line;
        EXPECT_EQ(parsed.text, line);
    }
}

class TraceTailTest : public testing::Test {
protected:
    TraceTailTest() { std::ofstream{file}; }
    void append(const std::string& text) { std::ofstream(file, std::ios::app) << text; }

    tests::TemporaryFolder folder;
    std::filesystem::path file = folder / "trace";
    TraceTail tail{file};
};

TEST_F(TraceTailTest, ALineIsReadOnceItIsComplete) {
    append("x [1.0] info: view 1 of 2\nx [2.0] info: vi");
    tail.read();
    ASSERT_EQ(tail.lines().size(), 1u);
    append("ew 1 of 3\n");
    tail.read();
    ASSERT_EQ(tail.lines().size(), 2u);
    EXPECT_EQ(tail.last("view ")->text, "view 1 of 3");
}

TEST_F(TraceTailTest, KeepsWhatEarlierLivesSaid) {
    for (const std::string life : {"first\n", "second\n", "third\n"}) {
        tail.restart();
        std::ofstream{file} << life;
        tail.read();
        ASSERT_EQ(tail.lines().size(), 1u);
    }
    std::ifstream earlier(tail.earlier_lives());
    const std::string text{std::istreambuf_iterator<char>(earlier), {}};
    EXPECT_EQ(text, "first\nsecond\n");
}

TEST_F(TraceTailTest, FindsTheFirstLineOfATimeOrLater) {
    append("x [1.0] info: view a\nx [2.0] info: view b\nx [3.0] info: view c\nview d\n");
    tail.read();
    ASSERT_NE(tail.find("view ", Instant{1500ms}), nullptr);
    EXPECT_EQ(tail.find("view ", Instant{1500ms})->text, "view b");
    EXPECT_EQ(tail.find("view ", Instant{3500ms}), nullptr);
    EXPECT_EQ(tail.find("lost ", Instant{}), nullptr);
}

}  // namespace
}  // namespace romano::bench::trace_tail_test
