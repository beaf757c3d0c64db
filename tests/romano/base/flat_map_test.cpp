#include "romano/base/flat_map.h"

#include <gmock/gmock.h>

#include <map>
#include <vector>

#include "romano/base/random.h"

namespace romano::flat_map_test {
namespace {

using testing::ElementsAre;
using testing::Pair;

TEST(FlatMap, KeepsItsEntriesInOrder) {
    FlatMap<int, int> map;
    map[3] = 30;
    map[1] = 10;
    map.insert_or_assign(2, 20);
    EXPECT_THAT(map, ElementsAre(Pair(1, 10), Pair(2, 20), Pair(3, 30)));
    EXPECT_EQ(map.rbegin()->first, 3);
}

TEST(FlatMap, TriesToEmplaceAndSaysWhetherThereWasNone) {
    FlatMap<int, std::vector<int>> map;
    EXPECT_TRUE(map.try_emplace(1, 2, 7).second);
    const auto [entry, is_new] = map.try_emplace(1);
    EXPECT_FALSE(is_new);
    EXPECT_THAT(entry->second, ElementsAre(2, 7)) << "it is left as it was";
}

TEST(FlatMap, FindsWhatIsThereAndNothingElse) {
    FlatMap<int, int> map;
    EXPECT_EQ(map.find(1), map.end());
    map[1] = 10;
    map[3] = 30;
    EXPECT_EQ(map.find(3)->second, 30);
    EXPECT_FALSE(map.contains(0));
    EXPECT_FALSE(map.contains(2));
    EXPECT_FALSE(map.contains(4));
}

TEST(FlatMap, AgreesWithAMapOfTheStandardLibrary) {
    Random random{1};
    FlatMap<std::uint32_t, std::uint32_t> flat;
    std::map<std::uint32_t, std::uint32_t> map;
    for (std::uint32_t i = 0; i < 2'000; ++i) {
        const std::uint32_t key = random.below(60);
        if (random.below(3) == 0) {
            EXPECT_EQ(flat.erase(key), map.erase(key));
        } else {
            flat[key] = map[key] = i;
        }
        if (i % 100 == 99) {
            const auto is_odd = [](const auto& entry) { return entry.second % 2 == 1; };
            EXPECT_EQ(erase_if(flat, is_odd), std::erase_if(map, is_odd));
        }
        ASSERT_TRUE(std::ranges::equal(flat, map, [](const auto& a, const auto& b) {
            return a.first == b.first && a.second == b.second;
        }));
    }
}

}  // namespace
}  // namespace romano::flat_map_test
