#include "experiments/sweep/progress_bar.h"

#include <gtest/gtest.h>

#include <array>

namespace romano::experiments::progress_bar_test {
namespace {

using namespace std::chrono_literals;

TEST(ProgressBar, FillsWithTheShare) {
    EXPECT_EQ(bar_of(0, 4), "[....]");
    EXPECT_EQ(bar_of(0.5, 4), "[##..]");
    EXPECT_EQ(bar_of(1, 4), "[####]");
    EXPECT_EQ(bar_of(7, 4), "[####]");
}

TEST(ProgressBar, TellsTimesAsPeopleDo) {
    EXPECT_EQ(duration_text(45s), "45 s");
    EXPECT_EQ(duration_text(185s), "3 min 05 s");
    EXPECT_EQ(duration_text(7800s), "2 h 10 min");
}

TEST(ProgressBar, IsOneLineACellWhereThereIsNoTerminal) {
    std::FILE* out = std::tmpfile();
    {
        ProgressBar bar{out, 4, 1};
        bar.show(0.5, "running");
        bar.finish_cell("first");
        bar.show(0.1, "running");
        bar.finish_quietly();
        bar.finish_cell("third");
    }
    std::rewind(out);
    std::array<char, 256> text{};
    const std::size_t size = std::fread(text.data(), 1, text.size(), out);
    std::fclose(out);
    EXPECT_EQ(std::string(text.data(), size), "[2/4] first\n[4/4] third\n");
}

}  // namespace
}  // namespace romano::experiments::progress_bar_test
