#include "overlay/cluster/replication/acknowledgements.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::acknowledgements_test {
namespace {

const broker::LogId home = test::log_of("home");
const broker::LogId publisher = test::log_of("publisher");
const broker::LogId other = test::log_of("other");

broker::LogEvent routed(const broker::LogId& log, broker::Seq seq) {
    return broker::Routed{.message = {log, seq}, .routes = {{.client_id = "robot", .qos = {}}}};
}

/// What is held here of the publisher's log, and all of the other one's.
class AcknowledgementsOfAHomesLog : public testing::Test {
protected:
    void apply(broker::Seq seq, const broker::LogEvent& event) {
        acknowledgements.on_event(home, seq, event, is_held);
        applied = seq;
    }
    [[nodiscard]] broker::Seq through() const {
        return acknowledgements.through(home, applied, is_held);
    }

    broker::Seq held = 0;
    broker::Seq applied = 0;
    Acknowledgements::IsHeld is_held = [this](const broker::LogId&,
                                              const broker::LogPosition& publish) {
        return publish.log != publisher || publish.seq <= held;
    };
    Acknowledgements acknowledgements;
};

TEST_F(AcknowledgementsOfAHomesLog, StopBeforeTheFirstMessageThatIsNotHeld) {
    apply(1, routed(other, 70));
    apply(2, routed(publisher, 5));
    apply(3, routed(other, 71));
    EXPECT_EQ(through(), 1U);
    held = 4;
    EXPECT_TRUE(acknowledgements.advance(is_held).empty());
    EXPECT_EQ(through(), 1U);
    held = 5;
    EXPECT_EQ(acknowledgements.advance(is_held), std::vector{home});
    EXPECT_EQ(through(), 3U);
}

TEST_F(AcknowledgementsOfAHomesLog, GoOnToTheNextMessageThatIsNotHeld) {
    apply(1, routed(publisher, 5));
    apply(2, routed(publisher, 6));
    held = 5;
    EXPECT_EQ(through(), 1U);
    EXPECT_EQ(acknowledgements.advance(is_held), std::vector{home});
    EXPECT_EQ(through(), 1U);
    EXPECT_TRUE(acknowledgements.advance(is_held).empty());
}

TEST_F(AcknowledgementsOfAHomesLog, WaitForWhatASessionBringsAlong) {
    broker::SessionPut put{};
    put.image.deliveries.push_back({.position = {publisher, 5}, .message = {}});
    put.image.deliveries.push_back({.position = {home, 1}, .message = {}});
    apply(1, test::published(home, 1));
    apply(2, put);
    EXPECT_EQ(through(), 1U);
    held = 5;
    EXPECT_EQ(through(), 2U);
}

TEST_F(AcknowledgementsOfAHomesLog, WaitForNothingThatIsForgotten) {
    apply(1, routed(publisher, 5));
    acknowledgements.forget(home);
    EXPECT_EQ(through(), 1U);
}

}  // namespace
}  // namespace romano::cluster::acknowledgements_test
