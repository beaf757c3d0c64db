#include "overlay/cluster/ended_logs.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const LogId first_life = test::log_of("b1", 1);
const LogId second_life = test::log_of("b1", 2);
const LogId other = test::log_of("b2", 1);

View view_of(std::vector<LogId> members) {
    std::ranges::sort(members);
    return {.members = std::move(members)};
}

TEST(EndedLogs, TheNewestLifeOfABrokerCounts) {
    EndedLogs ended;
    ended.on_view(view_of({other}), {{first_life, 9}, {second_life, 4}});
    EXPECT_THAT(ended.list(), ElementsAre(LogPosition{second_life, 4}));
    ended.learn(view_of({other}), {{first_life, 20}});
    EXPECT_THAT(ended.list(), ElementsAre(LogPosition{second_life, 4}));
}

// They went on from there, though nobody is left who holds as much.
TEST(EndedLogs, ALogEndsWhereThoseWhoHeldMostSaidSo) {
    EndedLogs ended;
    ended.on_view(view_of({other}), {{first_life, 9}});
    ended.on_view(view_of({other}), {{first_life, 5}});
    EXPECT_THAT(ended.list(), ElementsAre(LogPosition{first_life, 9}));
    ended.on_view(view_of({other}), {});
    EXPECT_THAT(ended.list(), ElementsAre(LogPosition{first_life, 9})) << "also held by nobody";
}

TEST(EndedLogs, WhoIsAMemberLivesOn) {
    EndedLogs ended;
    ended.on_view(view_of({other}), {{first_life, 9}});
    ended.on_view(view_of({first_life, other}), {});
    EXPECT_THAT(ended.list(), IsEmpty());
    ended.learn(view_of({first_life, other}), {{first_life, 9}});
    EXPECT_THAT(ended.list(), IsEmpty()) << "somebody has not heard of its return yet";
    ended.learn(view_of({second_life, other}), {{first_life, 9}});
    EXPECT_THAT(ended.list(), IsEmpty()) << "its later life got all";
}

}  // namespace
}  // namespace romano::cluster
