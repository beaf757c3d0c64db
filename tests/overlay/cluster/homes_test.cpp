#include "overlay/cluster/homes.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster {
namespace {

using test::erased;
using test::session;

constexpr BrokerId b1{1};
constexpr BrokerId b2{2};

broker::LogEvent session_from(const std::string& client, int host) {
    auto event = session(client);
    std::get<broker::SessionPut>(event).image.header.address = {test::address(host), {}};
    return event;
}

std::optional<BrokerId> home_of(const Homes& homes, const std::string& client) {
    const auto home = homes.of(client);
    return home ? std::optional{home->broker} : std::nullopt;
}

TEST(Homes, AClientIsFoundByItsIdAndByItsAddress) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1));
    EXPECT_EQ(home_of(homes, "a"), b1);
    const auto home = homes.at({test::address(1), {}});
    ASSERT_TRUE(home);
    EXPECT_EQ(home->client_id, "a");
    homes.on_event(b1, session_from("a", 2));  // it moved
    EXPECT_FALSE(homes.at({test::address(1), {}}));
    EXPECT_TRUE(homes.at({test::address(2), {}}));
    homes.on_event(b1, erased("a"));
    EXPECT_FALSE(homes.of("a"));
    EXPECT_FALSE(homes.at({test::address(2), {}}));
}

// After a heal an heir gives a session up that its home had all the time.
TEST(Homes, WhenTheLastOfTwoTakesItBackTheOtherIsHome) {
    Homes homes;
    homes.on_event(b1, session_from("a", 1));
    homes.on_event(b2, session_from("a", 1));
    EXPECT_EQ(home_of(homes, "a"), b2);
    homes.on_event(b2, erased("a"));
    EXPECT_EQ(home_of(homes, "a"), b1);
    EXPECT_TRUE(homes.at({test::address(1), {}}));
    homes.on_event(b2, session_from("a", 1));
    homes.forget(b1);
    EXPECT_EQ(home_of(homes, "a"), b2);
    EXPECT_TRUE(homes.at({test::address(1), {}}));
    homes.forget(b2);
    EXPECT_FALSE(homes.of("a"));
    EXPECT_FALSE(homes.at({test::address(1), {}}));
}

}  // namespace
}  // namespace romano::cluster
