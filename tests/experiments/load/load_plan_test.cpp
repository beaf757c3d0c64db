#include "experiments/load/load_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace romano::experiments::load_plan_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(LoadPlan, FewTopicsAreSharedByPublishersAndSubscribers) {
    const LoadPlan plan{.publishers = 3, .subscribers = 5, .topics = 2};
    EXPECT_EQ(plan.streams(), 3U);
    EXPECT_THAT(plan.published_by(2), ElementsAre(0));
    EXPECT_THAT(plan.heard_by(3 + 1), ElementsAre(1));
    EXPECT_EQ(plan.receivers_of(0), 3U);
    EXPECT_EQ(plan.receivers_of(1), 2U);
}

TEST(LoadPlan, ManyTopicsAreDealtInTurn) {
    const LoadPlan plan{.publishers = 2, .subscribers = 2, .topics = 5};
    EXPECT_EQ(plan.streams(), 5U);
    EXPECT_THAT(plan.published_by(0), ElementsAre(0, 2, 4));
    EXPECT_THAT(plan.heard_by(2 + 1), ElementsAre(1, 3));
    EXPECT_EQ(plan.receivers_of(4), 1U);
    EXPECT_EQ(plan.most_topics_of_a_client(), 3U);
}

TEST(LoadPlan, EachStreamHasOnePublisherWhoKnowsItsTopic) {
    for (const auto& [publishers, topics] : {std::pair{3U, 7U}, {7U, 3U}, {4U, 4U}, {1U, 1U}}) {
        const LoadPlan plan{.publishers = publishers, .subscribers = 1, .topics = topics};
        for (std::uint32_t stream = 0; stream < plan.streams(); ++stream) {
            EXPECT_THAT(plan.published_by(plan.publisher_of(stream)),
                        ::testing::Contains(plan.topic_of(stream)));
        }
    }
}

TEST(LoadPlan, AClientEitherPublishesOrHears) {
    const LoadPlan plan{.publishers = 2, .subscribers = 2, .topics = 1};
    EXPECT_THAT(plan.heard_by(1), IsEmpty());
    EXPECT_THAT(plan.published_by(2), IsEmpty());
}

}  // namespace
}  // namespace romano::experiments::load_plan_test
