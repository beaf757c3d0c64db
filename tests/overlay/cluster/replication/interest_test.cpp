#include "overlay/cluster/replication/interest.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::interest_test {
namespace {

using test::erased;
using test::session;
using test::subscribed;
using test::unsubscribed;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr BrokerId b1{1};
constexpr BrokerId b2{2};

TEST(Interest, APeerWithAMatchingSubscriberIsInterestedOnce) {
    Interest interest;
    interest.on_event(b1, subscribed("a", "pose"));
    interest.on_event(b1, subscribed("b", "pose"));
    interest.on_event(b1, subscribed("b", "+"));
    interest.on_event(b2, subscribed("c", "#"));
    EXPECT_THAT(interest.interested_in("pose"), ElementsAre(b1, b2));
    EXPECT_THAT(interest.interested_in("a/b"), ElementsAre(b2));
}

TEST(Interest, TheLastSubscriberTakesItAway) {
    Interest interest;
    interest.on_event(b1, subscribed("a", "pose"));
    interest.on_event(b1, subscribed("b", "pose"));
    interest.on_event(b1, unsubscribed("a", "pose"));
    EXPECT_THAT(interest.interested_in("pose"), ElementsAre(b1));
    interest.on_event(b1, unsubscribed("b", "pose"));
    EXPECT_THAT(interest.interested_in("pose"), IsEmpty());
}

TEST(Interest, ARepeatedSubscriptionCountsOnce) {
    Interest interest;
    interest.on_event(b1, subscribed("a", "pose"));
    interest.on_event(b1, subscribed("a", "pose"));
    interest.on_event(b1, unsubscribed("a", "pose"));
    EXPECT_THAT(interest.interested_in("pose"), IsEmpty());
}

TEST(Interest, ASessionTakesItsSubscriptionsAlong) {
    Interest interest;
    interest.on_event(b1, subscribed("a", "pose"));
    interest.on_event(b1, session("a"));  // connected anew, clean
    EXPECT_THAT(interest.interested_in("pose"), IsEmpty());
    interest.on_event(b1, subscribed("a", "pose"));
    interest.on_event(b1, erased("a"));
    EXPECT_THAT(interest.interested_in("pose"), IsEmpty());
}

TEST(Interest, ASnapshotReplacesWhatWasKnown) {
    Interest interest;
    interest.on_event(b1, subscribed("a", "old/#"));
    auto image = std::get<broker::SessionPut>(session("a")).image;
    image.subscriptions.push_back({.filter = "new/#"});
    broker::Mirror mirror{{b1, 1}};
    mirror.put(image);
    interest.reset(b1, mirror);
    interest.reset(b1, mirror);
    EXPECT_THAT(interest.interested_in("old/x"), IsEmpty());
    EXPECT_THAT(interest.interested_in("new/x"), ElementsAre(b1));
    interest.forget(b1);
    EXPECT_THAT(interest.interested_in("new/x"), IsEmpty());
}

}  // namespace
}  // namespace romano::cluster::interest_test
