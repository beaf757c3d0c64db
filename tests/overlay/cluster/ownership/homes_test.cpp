#include "overlay/cluster/ownership/homes.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::homes_test {
namespace {

using test::erased;
using test::session;

constexpr BrokerId b1{1};
constexpr BrokerId b2{2};

/// The client at that address, talking to one service address or another.
broker::Origin place(int host, int via = 100) {
    return {test::address(via), {test::address(host), {}}};
}

broker::LogEvent session_from(const std::string& client, int host, int via = 100,
                              std::uint64_t heard_at = 0) {
    auto event = session(client, test::address(via));
    broker::SessionHeader& header = std::get<broker::SessionPut>(event).image.header;
    header.address = {test::address(host), {}};
    header.last_heard = broker::HybridTime{heard_at};
    return event;
}

TEST(Homes, AClientIsFoundByItsIdAndByItsAddress) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1));
    EXPECT_EQ(homes.of("a"), b1);
    EXPECT_EQ(homes.at(place(1)), "a");
    homes.on_event(b1, session_from("a", 2));  // it moved
    EXPECT_FALSE(homes.at(place(1)));
    EXPECT_TRUE(homes.at(place(2)));
    homes.on_event(b1, erased("a"));
    EXPECT_FALSE(homes.of("a"));
    EXPECT_FALSE(homes.at(place(2)));
}

// After a heal an heir gives a session up that its home had all the time.
TEST(Homes, WhenTheLastOfTwoTakesItBackTheOtherIsHome) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1));
    homes.on_event(b2, session_from("a", 1));
    EXPECT_EQ(homes.of("a"), b2);
    homes.on_event(b2, erased("a"));
    EXPECT_EQ(homes.of("a"), b1);
    EXPECT_TRUE(homes.at(place(1)));
    homes.on_event(b2, session_from("a", 1));
    homes.forget(b1);
    EXPECT_EQ(homes.of("a"), b2);
    EXPECT_TRUE(homes.at(place(1)));
    homes.forget(b2);
    EXPECT_FALSE(homes.of("a"));
    EXPECT_FALSE(homes.at(place(1)));
}

// The member that had the client all the time was not asked for it (simulator, as shipped, seed
// 20945).
TEST(Homes, I7_WhatAHomeSaidWhoseLogHasEndedCountsOnlyWhereNobodyElseSaysSo) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1));
    homes.on_event(b2, session_from("a", 1));
    homes.on_event(b2, session_from("b", 2));
    homes.on_end(b2);
    EXPECT_EQ(homes.of("a"), b1);
    EXPECT_EQ(homes.of("b"), b2);
    homes.on_event(b2, session_from("a", 1));
    EXPECT_EQ(homes.of("a"), b2) << "it goes on";
}

// A NAT that keeps source ports; or a client that was started again under another id.
TEST(Homes, OfTwoClientsAtOneAddressEachIsFoundByTheServiceAddressThatItTalksTo) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1, 101));
    ASSERT_TRUE(homes.only_one_at({test::address(1), {}}));
    homes.on_event(b2, session_from("b", 1, 102));
    EXPECT_EQ(homes.at(place(1, 101)), "a");
    EXPECT_EQ(homes.at(place(1, 102)), "b");
    EXPECT_FALSE(homes.at(place(1, 103)));
    EXPECT_FALSE(homes.only_one_at({test::address(1), {}}));
    homes.on_event(b2, erased("b"));
    EXPECT_EQ(homes.only_one_at({test::address(1), {}}), "a");
}

TEST(Homes, OfTwoClientsHeardAtOnePlaceTheLaterOneIsThere) {
    for (const bool later_is_told_first : {false, true}) {
        Homes homes;
        const auto earlier = session_from("a", 1, 101, 1);
        const auto later = session_from("b", 1, 101, 2);
        homes.on_event(b1, later_is_told_first ? later : earlier);
        homes.on_event(b2, later_is_told_first ? earlier : later);
        EXPECT_EQ(homes.at(place(1, 101)), "b");
        EXPECT_EQ(homes.only_one_at({test::address(1), {}}), "b");
    }
}

TEST(Homes, WhoWasDisplacedIsThereAgainOnceItWasHeardLater) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1, 101, 1));
    homes.on_event(b2, session_from("b", 1, 101, 2));
    homes.on_event(b2, erased("b"));
    EXPECT_FALSE(homes.at(place(1, 101))) << "nobody knows who speaks there";
    homes.on_event(b1, session_from("a", 1, 101, 3));
    EXPECT_EQ(homes.at(place(1, 101)), "a");
}

TEST(Homes, WhatTheLastOfTwoHomesSaysOfAPlaceCounts) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1, 101, 2));
    auto left = session_from("a", 1, 101, 3);
    std::get<broker::SessionPut>(left).image.header.state = broker::SessionState::disconnected;
    homes.on_event(b2, left);
    EXPECT_FALSE(homes.only_one_at({test::address(1), {}}));
    homes.on_event(b2, erased("a"));
    EXPECT_TRUE(homes.at(place(1, 101)));
    homes.on_event(b1, erased("a"));
    EXPECT_FALSE(homes.at(place(1, 101)));
}

TEST(Homes, WhoIsLostIsConnectedFromNoAddress) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1, 101));
    homes.on_event(b2, session_from("b", 1, 102));
    broker::Published will{};
    will.message = broker::MessagePtr{broker::Message{}};
    will.will_of = "b";
    homes.on_event(b2, will);
    EXPECT_EQ(homes.only_one_at({test::address(1), {}}), "a");
}

TEST(Homes, AnotherClientSharesTheAddressUnlessItWasHeardEarlierAtTheSamePlace) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1, 101, 1));
    broker::SessionHeader own;
    own.client_id = "b";
    own.address = {test::address(1), {}};
    own.last_heard = broker::HybridTime{2};
    own.via = test::address(101);
    EXPECT_FALSE(homes.share_address_with(own));  // "a" was displaced by it
    own.via = test::address(102);
    EXPECT_TRUE(homes.share_address_with(own));
    own.client_id = "a";
    EXPECT_FALSE(homes.share_address_with(own));
}

}  // namespace
}  // namespace romano::cluster::homes_test
