// How far a broker has worked through its peers' logs, and what its own log says of that.

#include "broker/core/cursors.h"

#include <gmock/gmock.h>

#include "tests/broker/core/scripted_client.h"

namespace romano::broker::cursors_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const LogId b2{broker_id_of("b2"), 1};
const LogId b3{broker_id_of("b3"), 1};
const LogId first = std::min(b2, b3);
const LogId second = std::max(b2, b3);

TEST(Cursors, OnlyGoOn) {
    Cursors cursors;
    EXPECT_TRUE(cursors.advance({b2, 5}));
    EXPECT_FALSE(cursors.advance({b2, 5}));
    EXPECT_FALSE(cursors.advance({b2, 3}));
    EXPECT_EQ(cursors.at(b2), 5U);
    EXPECT_EQ(cursors.at(b3), 0U);
}

TEST(Cursors, StandInTheOrderOfLogs) {
    Cursors cursors;
    cursors.advance({second, 7});
    cursors.advance({first, 5});
    EXPECT_THAT(cursors.all(), ElementsAre(LogPosition{first, 5}, LogPosition{second, 7}));
}

TEST(Cursors, ThatTheLogKnowsOfAreNotToldAgain) {
    Cursors cursors;
    cursors.advance({first, 5});
    cursors.advance({second, 7});
    cursors.logged({first, 5});
    EXPECT_THAT(cursors.unlogged(), ElementsAre(LogPosition{second, 7}));
    cursors.advance({first, 6});
    EXPECT_EQ(cursors.unlogged().size(), 2U);
}

TEST(Cursors, OfLogsThatAreOverAreForgotten) {
    Cursors cursors;
    cursors.advance({b2, 5});
    cursors.logged({b2, 5});
    cursors.forget([](const LogId& log) { return log == b2; });
    EXPECT_EQ(cursors.size(), 0U);
    EXPECT_TRUE(cursors.advance({b2, 1}));
    EXPECT_EQ(cursors.unlogged().size(), 1U) << "nor does the log know of them";
}

/// With each broker there are more logs, and more brokers who read what all say of them.
TEST(Cursors, ThatMovedAreToldInOneEvent) {
    ScriptedBroker home{logging_options()};
    for (const LogId& log : {b2, b3}) {
        Message message{};
        message.topic = "pose";
        message.qos = Qos::at_least_once;
        message.position = {log, 4};
        home.core.on_peer_message(home.now, message, home.actions);
    }
    home.drain();
    ASSERT_THAT(home.log, IsEmpty()) << "nobody here wants them";

    home.core.append_cursors(home.actions);
    home.drain();
    ASSERT_EQ(home.log.size(), 1U);
    const auto& cursor = std::get<Cursor>(home.log.front());
    EXPECT_THAT(cursor.through, ElementsAre(LogPosition{first, 4}, LogPosition{second, 4}));
    home.mirror.apply(1, home.log.front());
    EXPECT_EQ(home.mirror.cursor(b2), 4U);
    EXPECT_EQ(home.mirror.cursor(b3), 4U);

    home.core.append_cursors(home.actions);
    home.drain();
    EXPECT_EQ(home.log.size(), 1U) << "when they have moved again";
}

}  // namespace
}  // namespace romano::broker::cursors_test
