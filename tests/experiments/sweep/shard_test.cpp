#include "experiments/sweep/shard.h"

#include <gtest/gtest.h>

namespace romano::experiments::shard_test {
namespace {

TEST(Shard, IsOneOfSoMany) {
    const auto shard = parse_shard("2/8");
    ASSERT_TRUE(shard);
    EXPECT_EQ(shard->number, 2u);
    EXPECT_EQ(shard->of, 8u);
    EXPECT_EQ(text_of(*shard), "2/8");
}

TEST(Shard, OtherTextsAreNone) {
    for (const char* text : {"", "/", "2", "0/3", "4/3", "1/0", "1/", "/3", "1/3x", "-1/3", "1/2/3",
                             "1/100001", "99999999999/99999999999"}) {
        EXPECT_FALSE(parse_shard(text)) << text;
    }
}

}  // namespace
}  // namespace romano::experiments::shard_test
