#include "overlay/cluster/replication/interest.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <vector>

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

/// Mirrors of two brokers' logs, and what is known from both.
struct Peers {
    std::map<BrokerId, broker::Mirror> mirrors{{b1, broker::Mirror{{b1, 1}}},
                                               {b2, broker::Mirror{{b2, 1}}}};
    Interest interest;

    void tell(BrokerId peer, const broker::LogEvent& event) {
        broker::Mirror& mirror = mirrors.at(peer);
        interest.on_event(mirror, event);
        mirror.apply(mirror.applied() + 1, event);
    }
    void sessions_at(BrokerId peer, std::initializer_list<const char*> clients) {
        for (const char* client : clients) tell(peer, session(client));
    }
    [[nodiscard]] std::vector<BrokerId> interested_in(std::string_view topic) const {
        return interest.interested_in(topic);
    }
};

TEST(Interest, APeerWithAMatchingSubscriberIsInterestedOnce) {
    Peers peers;
    peers.sessions_at(b1, {"a", "b"});
    peers.sessions_at(b2, {"c"});
    peers.tell(b1, subscribed("a", "pose"));
    peers.tell(b1, subscribed("b", "pose"));
    peers.tell(b1, subscribed("b", "+"));
    peers.tell(b2, subscribed("c", "#"));
    EXPECT_THAT(peers.interested_in("pose"), ElementsAre(b1, b2));
    EXPECT_THAT(peers.interested_in("a/b"), ElementsAre(b2));
}

TEST(Interest, TheLastSubscriberTakesItAway) {
    Peers peers;
    peers.sessions_at(b1, {"a", "b"});
    peers.tell(b1, subscribed("a", "pose"));
    peers.tell(b1, subscribed("b", "pose"));
    peers.tell(b1, unsubscribed("a", "pose"));
    EXPECT_THAT(peers.interested_in("pose"), ElementsAre(b1));
    peers.tell(b1, unsubscribed("a", "pose"));
    EXPECT_THAT(peers.interested_in("pose"), ElementsAre(b1)) << "it had none any more";
    peers.tell(b1, unsubscribed("b", "pose"));
    EXPECT_THAT(peers.interested_in("pose"), IsEmpty());
}

TEST(Interest, ARepeatedSubscriptionCountsOnce) {
    Peers peers;
    peers.sessions_at(b1, {"a"});
    peers.tell(b1, subscribed("a", "pose"));
    peers.tell(b1, subscribed("a", "pose"));
    peers.tell(b1, unsubscribed("a", "pose"));
    EXPECT_THAT(peers.interested_in("pose"), IsEmpty());
}

TEST(Interest, ASessionTakesItsSubscriptionsAlong) {
    Peers peers;
    peers.sessions_at(b1, {"a"});
    peers.tell(b1, subscribed("a", "pose"));
    peers.sessions_at(b1, {"a"});  // connected anew, clean
    EXPECT_THAT(peers.interested_in("pose"), IsEmpty());
    peers.tell(b1, subscribed("a", "pose"));
    peers.tell(b1, erased("a"));
    EXPECT_THAT(peers.interested_in("pose"), IsEmpty());
}

TEST(Interest, ASnapshotReplacesWhatWasKnown) {
    Peers peers;
    peers.sessions_at(b1, {"a"});
    peers.tell(b1, subscribed("a", "old/#"));
    auto image = std::get<broker::SessionPut>(session("a")).image;
    image.subscriptions.push_back({.filter = "new/#"});
    broker::Mirror mirror{{b1, 1}};
    mirror.put(image);
    peers.interest.reset(mirror);
    peers.interest.reset(mirror);
    EXPECT_THAT(peers.interested_in("old/x"), IsEmpty());
    EXPECT_THAT(peers.interested_in("new/x"), ElementsAre(b1));
    peers.interest.forget(b1);
    peers.interest.on_turn();
    EXPECT_THAT(peers.interested_in("new/x"), IsEmpty());
}

// I8: of 10,000 sessions that took three milliseconds.
TEST(Interest, IsForgottenInPieces) {
    constexpr int filters = 2'000;
    Peers peers;
    peers.sessions_at(b1, {"a"});
    peers.sessions_at(b2, {"b"});
    for (int i = 0; i < filters; ++i) peers.tell(b1, subscribed("a", std::to_string(i)));
    peers.tell(b2, subscribed("b", "7"));
    const auto count = [&peers] {
        int known = 0;
        for (int i = 0; i < filters; ++i) {
            known +=
                static_cast<int>(std::ranges::count(peers.interested_in(std::to_string(i)), b1));
        }
        return known;
    };
    peers.interest.forget(b1);
    for (int known = filters; known > 0;) {
        peers.interest.on_turn();
        const int left = count();
        ASSERT_LT(left, known);
        ASSERT_GE(left, known - 512);
        known = left;
    }
    EXPECT_THAT(peers.interested_in("7"), ElementsAre(b2));
}

TEST(Interest, OfABrokerThatIsBackIsNotForgotten) {
    Peers peers;
    peers.sessions_at(b1, {"a"});
    peers.tell(b1, subscribed("a", "pose"));
    peers.interest.forget(b1);
    peers.interest.reset(peers.mirrors.at(b1));
    peers.interest.on_turn();
    EXPECT_THAT(peers.interested_in("pose"), ElementsAre(b1));
}

}  // namespace
}  // namespace romano::cluster::interest_test
