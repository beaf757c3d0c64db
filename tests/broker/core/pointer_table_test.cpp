// The table behind the look-ups by address and by topic name.

#include "broker/core/pointer_table.h"

#include <gtest/gtest.h>

#include <deque>
#include <map>

#include "romano/base/random.h"

namespace romano::broker::pointer_table_test {
namespace {

TEST(PointerTable, AgreesWithAMapWhateverCollides) {
    Random random{11};
    struct Thing {
        std::uint32_t key;
    };
    std::deque<Thing> things;
    PointerTable<Thing> table;
    std::map<std::uint32_t, Thing*> model;
    const auto hash = [](std::uint32_t key) { return std::size_t{key % 50}; };  // many equal ones
    const auto find = [&](std::uint32_t key) {
        return table.find(hash(key), [key](const Thing& thing) { return thing.key == key; });
    };
    for (int step = 0; step < 20'000; ++step) {
        const std::uint32_t key = random.below(300);
        const auto known = model.find(key);
        if (known != model.end()) {
            ASSERT_EQ(find(key), known->second);
            table.erase(hash(key), known->second);
            model.erase(known);
        } else {
            ASSERT_EQ(find(key), nullptr);
            things.push_back({key});
            table.insert(hash(key), &things.back());
            model.emplace(key, &things.back());
        }
        ASSERT_EQ(table.size(), model.size());
    }
}

}  // namespace
}  // namespace romano::broker::pointer_table_test
