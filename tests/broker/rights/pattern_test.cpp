// Which topics and filters a rule is about: MQTT's filters, and %i for the own id.

#include "broker/rights/pattern.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "romano/mqttsn/topic.h"

namespace romano::rights::pattern_test {
namespace {

TEST(RightsPattern, OwnIdFillsALevelAndStandsForOneClient) {
    EXPECT_TRUE(is_valid_pattern("robots/%i/#"));
    EXPECT_FALSE(is_valid_pattern("robots/%i-left"));
    EXPECT_FALSE(is_valid_pattern("a/#/b"));
    EXPECT_FALSE(is_valid_pattern(""));
    EXPECT_TRUE(matches("robots/%i/#", "r1", "robots/r1/pose"));
    EXPECT_TRUE(matches("robots/%i/#", "r1", "robots/r1"));
    EXPECT_FALSE(matches("robots/%i/#", "r1", "robots/r2/pose"));
    EXPECT_FALSE(matches("robots/%i/#", "r1", "robots/r11/pose"));
    EXPECT_FALSE(matches("%i", "r1", "r1/pose"));
}

TEST(RightsPattern, AnIdIsNeverAWildcardNorAHiddenTopicNorNothing) {
    EXPECT_FALSE(matches("%i", "+", "r1"));
    EXPECT_FALSE(matches("%i/#", "#", "r1/pose"));
    EXPECT_FALSE(matches("%i/#", "$SYS", "$SYS/brokers/b1"));
    EXPECT_FALSE(matches("a/%i/b", "", "a//b"));
    EXPECT_FALSE(matches("a/%i", "b/c", "a/b/c"));
    EXPECT_FALSE(overlaps("a/%i", "", "a/+"));
    EXPECT_FALSE(covers("a/%i", "+", "a/b"));
}

TEST(RightsPattern, AFilterIsCoveredWhenAllItsTopicsAre) {
    EXPECT_TRUE(covers("#", "r1", "a/+/b/#"));
    EXPECT_TRUE(covers("+/%i/#", "r1", "pose/r1"));
    EXPECT_TRUE(covers("+/%i/#", "r1", "+/r1/+"));
    EXPECT_TRUE(covers("a/#", "r1", "a"));
    EXPECT_FALSE(covers("+/%i/#", "r1", "+/+/pose"));
    EXPECT_FALSE(covers("a/+", "r1", "a/#"));
    EXPECT_FALSE(covers("a/b", "r1", "a/+"));
    EXPECT_FALSE(covers("#", "r1", "$SYS/#"));
    EXPECT_FALSE(covers("a", "r1", "a/#"));
}

TEST(RightsPattern, AFilterOverlapsWhenSomeOfItsTopicsAreThePatterns) {
    EXPECT_TRUE(overlaps("+/%i/#", "r1", "#"));
    EXPECT_TRUE(overlaps("+/%i/#", "r1", "robots/+/pose"));
    EXPECT_TRUE(overlaps("a/#", "r1", "a"));
    EXPECT_TRUE(overlaps("a", "r1", "a/#"));
    EXPECT_FALSE(overlaps("+/%i/#", "r1", "robots/r2/#"));
    EXPECT_FALSE(overlaps("a/b", "r1", "a"));
    EXPECT_FALSE(overlaps("$SYS/#", "r1", "#"));
    EXPECT_FALSE(overlaps("#", "r1", "$SYS/#"));
    EXPECT_FALSE(overlaps("+/b", "r1", "$SYS/b"));
}

/// All filters and names over two words, up to three levels.
void add_texts(std::vector<std::string>& out, const std::string& front, int levels,
               const std::vector<std::string>& words) {
    for (const std::string& word : words) {
        out.push_back(front + word);
        if (levels > 1 && word != "#") add_texts(out, front + word + "/", levels - 1, words);
    }
}

TEST(RightsPattern, CoversAndOverlapsAreWhatTheNamesSay) {
    std::vector<std::string> filters;
    std::vector<std::string> names;
    add_texts(filters, "", 3, {"a", "$b", "+", "#"});
    add_texts(names, "", 4, {"a", "$b", "c"});
    for (const std::string& pattern : filters) {
        for (const std::string& filter : filters) {
            bool all = true;
            bool some = false;
            for (const std::string& name : names) {
                EXPECT_EQ(matches(pattern, "", name), mqttsn::matches(pattern, name));
                if (!mqttsn::matches(filter, name)) continue;
                const bool is_one = matches(pattern, "", name);
                all = all && is_one;
                some = some || is_one;
            }
            ASSERT_EQ(covers(pattern, "", filter), all) << pattern << " and " << filter;
            ASSERT_EQ(overlaps(pattern, "", filter), some) << pattern << " and " << filter;
        }
    }
}

}  // namespace
}  // namespace romano::rights::pattern_test
