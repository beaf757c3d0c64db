#include "overlay/dds/make_room.h"

#include <gmock/gmock.h>

#include <chrono>
#include <map>

namespace romano::dds::make_room_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::Key;

using Moment = std::chrono::steady_clock::time_point;

struct Peer {
    Moment heard_at;
};

TEST(MakeRoom, AFullTableKeepsWhoWasHeardInTheLastMinute) {
    const Moment now{1h};
    std::map<int, Peer> peers{{1, {now - 1min}}, {2, {now}}};
    EXPECT_FALSE(make_room(peers, 2, now));
    EXPECT_THAT(peers, ElementsAre(Key(1), Key(2)));
}

TEST(MakeRoom, ANewcomerTakesThePlaceOfWhoWasSilentLongest) {
    const Moment now{1h};
    std::map<int, Peer> peers{{1, {now - 61s}}, {2, {now - 62s}}, {3, {now}}};
    EXPECT_TRUE(make_room(peers, 3, now));
    EXPECT_THAT(peers, ElementsAre(Key(1), Key(3)));
}

TEST(MakeRoom, WhoIsSilentKeepsItsPlaceWhileThereAreOthers) {
    const Moment now{1h};
    std::map<int, Peer> peers{{1, {now - 1min - 1s}}};
    EXPECT_TRUE(make_room(peers, 2, now));
    EXPECT_THAT(peers, ElementsAre(Key(1)));
}

}  // namespace
}  // namespace romano::dds::make_room_test
