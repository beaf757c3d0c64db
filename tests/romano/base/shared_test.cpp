#include "romano/base/shared.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <variant>

namespace romano::shared_test {
namespace {

/// Counts those that live.
struct Counted {
    explicit Counted(int& living) : living_(living) { ++living_; }
    Counted(const Counted& other) : living_(other.living_) { ++living_; }
    ~Counted() { --living_; }

private:
    int& living_;
};

TEST(Shared, LivesAsLongAsItsLastOwner) {
    int living = 0;
    Shared<Counted> first{Counted{living}};
    EXPECT_EQ(living, 1);
    {
        const Shared<Counted> second = first;
        EXPECT_EQ(living, 1) << "a copy shares it";
        first = {};
        EXPECT_EQ(living, 1);
    }
    EXPECT_EQ(living, 0);
}

TEST(Shared, StaysWhenItIsGivenToItself) {
    Shared<std::string> text{"pose"};
    const Shared<std::string>& same = text;
    text = same;
    EXPECT_EQ(*text, "pose");
}

TEST(Shared, IsOfNothingWhenItWasMovedFrom) {
    Shared<std::string> text{"pose"};
    const Shared<std::string> taken = std::move(text);
    EXPECT_EQ(taken->size(), 4U);
    EXPECT_FALSE(text);  // NOLINT(bugprone-use-after-move)
}

TEST(Shared, EqualsItsCopiesAndNoOtherOfTheSameValue) {
    const Shared<std::string> text{"pose"};
    EXPECT_EQ(text, Shared<std::string>{text});
    EXPECT_FALSE(text == Shared<std::string>{"pose"});
}

TEST(Shared, IsMadeOfWhatMakesItsValue) {
    const Shared<std::variant<int, std::string>> number = 7;
    EXPECT_EQ(std::get<int>(*number), 7);
}

}  // namespace
}  // namespace romano::shared_test
