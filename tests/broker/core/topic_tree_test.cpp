// Topic matching [MQTT 3.1.1 4.7], which MQTT-SN leaves to MQTT (G26).

#include "broker/core/topic_tree.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "romano/base/random.h"
#include "romano/mqttsn/topic.h"

namespace romano::broker::topic_tree_test {
namespace {

using Tree = TopicTree<int, char>;

std::vector<int> matching(const Tree& tree, std::string_view name) {
    std::vector<int> found;
    tree.match(name, [&](int subscriber, char) { found.push_back(subscriber); });
    return found;
}

bool matches(std::string_view filter, std::string_view name) {
    Tree tree;
    tree.put(filter, 1, 'x');
    return tree.matches(name);
}

TEST(TopicTree, PlainFilterMatchesItsNameOnly) {
    EXPECT_TRUE(matches("a/b", "a/b"));
    EXPECT_FALSE(matches("a/b", "a/b/c"));
    EXPECT_FALSE(matches("a/b", "a"));
    EXPECT_FALSE(matches("a/b", "A/b"));
}

TEST(TopicTree, EmptyLevelsCount) {
    EXPECT_FALSE(matches("a/b", "/a/b"));
    EXPECT_FALSE(matches("a/b", "a/b/"));
    EXPECT_TRUE(matches("+/+", "/x"));
    EXPECT_TRUE(matches("/+", "/x"));
    EXPECT_FALSE(matches("+", "/x"));
    EXPECT_TRUE(matches("a//c", "a//c"));
    EXPECT_TRUE(matches("a/+/c", "a//c"));
}

TEST(TopicTree, PlusFillsExactlyOneLevel) {
    EXPECT_TRUE(matches("a/+", "a/b"));
    EXPECT_TRUE(matches("a/+", "a/"));
    EXPECT_FALSE(matches("a/+", "a"));
    EXPECT_FALSE(matches("a/+", "a/b/c"));
    EXPECT_TRUE(matches("+/b", "a/b"));
}

TEST(TopicTree, HashMatchesTheRestAndTheParent) {
    EXPECT_TRUE(matches("a/#", "a"));
    EXPECT_TRUE(matches("a/#", "a/b"));
    EXPECT_TRUE(matches("a/#", "a/b/c"));
    EXPECT_FALSE(matches("a/#", "b"));
    EXPECT_TRUE(matches("#", "a/b"));
    EXPECT_TRUE(matches("a/+/#", "a/b"));
    EXPECT_FALSE(matches("a/+/#", "a"));
}

TEST(TopicTree, FilterThatBeginsWithAWildcardDoesNotMatchDollarNames) {
    EXPECT_FALSE(matches("#", "$SYS/x"));
    EXPECT_FALSE(matches("+/x", "$SYS/x"));
    EXPECT_TRUE(matches("$SYS/#", "$SYS/x"));
    EXPECT_TRUE(matches("$SYS/+", "$SYS/x"));
    EXPECT_TRUE(matches("a/+", "a/$x"));
    EXPECT_TRUE(matches("a/#", "a/$x"));
}

TEST(TopicTree, SameFilterAgainReplacesTheGrant) {
    Tree tree;
    tree.put("a/+", 7, 'x');
    tree.put("a/+", 7, 'y');
    EXPECT_EQ(tree.size(), 1u);
    ASSERT_NE(tree.find("a/+", 7), nullptr);
    EXPECT_EQ(*tree.find("a/+", 7), 'y');
    EXPECT_EQ(tree.find("a/+", 8), nullptr);
    EXPECT_EQ(tree.find("a/b", 7), nullptr);
}

TEST(TopicTree, RemoveComparesFiltersAsText) {
    Tree tree;
    tree.put("a/+", 1, 'x');
    tree.put("a/b", 1, 'x');
    EXPECT_FALSE(tree.remove("a/#", 1));
    EXPECT_FALSE(tree.remove("a/+", 2));
    EXPECT_TRUE(tree.remove("a/+", 1));
    EXPECT_EQ(matching(tree, "a/b"), std::vector<int>{1});
    EXPECT_TRUE(tree.remove("a/b", 1));
    EXPECT_TRUE(tree.empty());
}

TEST(TopicTree, RemoveAllLeavesTheOthers) {
    Tree tree;
    for (const char* filter : {"a/b", "a/+", "a/#", "+/b", "#", "c"}) {
        tree.put(filter, 1, 'x');
        tree.put(filter, 2, 'x');
        tree.put(std::string{"of/1/"} + filter, 1, 'x');
    }
    tree.remove_all(1);
    EXPECT_EQ(matching(tree, "a/b"), std::vector<int>(5, 2));
    EXPECT_EQ(matching(tree, "c"), (std::vector<int>{2, 2}));
    EXPECT_EQ(tree.size(), 6U);
    tree.remove_all(2);
    EXPECT_TRUE(tree.empty());
}

TEST(TopicTree, RemoveSomeGetsToAllThoughOthersComeAndGoMeanwhile) {
    Tree tree;
    const auto filter = [](int number) { return "robot/" + std::to_string(number); };
    for (int number = 0; number < 100; ++number) {
        tree.put(filter(number), 1, 'x');
        if (number % 3 == 0) tree.put(filter(number), 2, 'x');
    }
    tree.put("robot/+", 1, 'x');
    std::size_t left = 100;
    for (int piece = 0; left > 0; ++piece) {
        ASSERT_FALSE(matching(tree, "robot/x").empty()) << "it goes last";
        left = tree.remove_some(1, left, 10);
        tree.put(filter(100 + piece), 2, 'x');
        (void)tree.remove(filter(3 * piece), 2);
    }
    for (int number = 0; number < 110; ++number) {
        const bool is_others = number < 30 ? false : number >= 100 || number % 3 == 0;
        EXPECT_EQ(matching(tree, filter(number)), std::vector<int>(is_others ? 1 : 0, 2)) << number;
    }
}

TEST(TopicTree, VisitsSubscribersInOrderWhateverTheOrderOfSubscription) {
    Tree tree;
    for (const int subscriber : {3, 1, 2}) tree.put("a", subscriber, 'x');
    tree.put("+", 0, 'x');
    EXPECT_EQ(matching(tree, "a"), (std::vector<int>{1, 2, 3, 0}));
}

TEST(TopicTree, AgreesWithTheMatchingRuleOnRandomFilters) {
    Random random{7};
    const auto level = [&](bool wild) {
        static const std::vector<std::string> names = {"a", "b", "", "$s", "+"};
        return names[random.below(wild ? 5 : 4)];
    };
    const auto text = [&](bool wild) {
        std::string made = level(wild);
        for (std::uint32_t more = random.below(3); more > 0; --more) made += "/" + level(wild);
        if (wild && random.below(4) == 0) made += "/#";
        return made.empty() ? std::string{"a"} : made;
    };
    Tree tree;
    std::map<int, std::string> filters;
    for (int step = 0; step < 3000; ++step) {
        const int subscriber = static_cast<int>(random.below(40));
        if (filters.contains(subscriber)) {
            if (step % 2 == 0) {
                tree.remove_all(subscriber);
            } else {
                EXPECT_TRUE(tree.remove(filters[subscriber], subscriber));
            }
            filters.erase(subscriber);
        } else {
            filters[subscriber] = text(true);
            tree.put(filters[subscriber], subscriber, 'x');
        }
        EXPECT_EQ(tree.size(), filters.size());
        const std::string name = text(false);
        std::set<int> expected;
        for (const auto& [who, filter] : filters) {
            if (mqttsn::matches(filter, name)) expected.insert(who);
        }
        const std::vector<int> found = matching(tree, name);
        EXPECT_EQ(std::set<int>(found.begin(), found.end()), expected) << name;
        EXPECT_EQ(found.size(), expected.size()) << name;
    }
}

}  // namespace
}  // namespace romano::broker::topic_tree_test
