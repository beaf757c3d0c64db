#include "overlay/cluster/agreement/ended_logs.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::ended_logs_test {
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
}

// One that stood still, and holds more of it, may come back later (simulator, faults `relapse`,
// seed 9881208).
TEST(EndedLogs, AFormerLifeHasEndedThoughItsBrokerIsBack) {
    EndedLogs ended;
    ended.on_view(view_of({other}), {{first_life, 9}});
    ended.on_view(view_of({second_life, other}), {});
    EXPECT_THAT(ended.list(), ElementsAre(LogPosition{first_life, 9}));
}

TEST(EndedLogs, AreBounded) {
    EndedLogs ended;
    for (std::size_t i = 0; i < EndedLogs::most + 10; ++i) {
        ended.learn({}, {{test::log_of("gone" + std::to_string(i)), 1}});
    }
    EXPECT_EQ(ended.list().size(), EndedLogs::most);
    const LogId known = ended.list().front().log;
    ended.learn({}, {{known, 2}});
    EXPECT_EQ(ended.list().front(), (LogPosition{known, 2}));
}

TEST(View, KnowsOfTheLaterLifeOfABroker) {
    const View view = view_of({second_life, other});
    EXPECT_TRUE(view.has_later_life_of(first_life));
    EXPECT_FALSE(view.has_later_life_of(second_life));
    EXPECT_FALSE(view.has_later_life_of(test::log_of("b3", 0)));
}

}  // namespace
}  // namespace romano::cluster::ended_logs_test
