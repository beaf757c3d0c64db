#include "overlay/sim/promises.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace romano::sim::promises_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

// A judge that never finds anything is worth nothing: each rule once broken by hand.
class PromisesTest : public testing::Test {
protected:
    void subscribed(Instant from) {
        ledger.subscriptions.push_back({.subscriber = "listener",
                                        .filter = "t/#",
                                        .granted = Qos::exactly_once,
                                        .from = from,
                                        .until = std::nullopt});
    }
    void sent(std::uint32_t number, Qos qos, bool acknowledged = true) {
        Sent message{.publisher = "talker",
                     .number = number,
                     .topic = "t/x",
                     .qos = qos,
                     .at = Instant{1s},
                     .acknowledged = std::nullopt};
        if (acknowledged) message.acknowledged = Instant{2s};
        ledger.sent[{"talker", number}] = message;
    }
    void received(std::uint32_t number, Qos qos) {
        ledger.receptions.push_back({.subscriber = "listener",
                                     .publisher = "talker",
                                     .number = number,
                                     .qos = qos,
                                     .at = Instant{3s}});
    }
    std::vector<Promise> judged(std::vector<Span> parted = {}) {
        Violations violations;
        judge_safety(ledger, {.links_keep_order = true, .parted = std::move(parted)}, violations);
        judge_completeness(ledger, {}, violations);
        std::vector<Promise> promises;
        for (const Violation& violation : violations) promises.push_back(violation.promise);
        return promises;
    }

    Ledger ledger;
};

TEST_F(PromisesTest, AreKeptByAQuietExchange) {
    subscribed(Instant{0s});
    for (std::uint32_t number : {1U, 2U}) {
        sent(number, Qos::exactly_once);
        received(number, Qos::exactly_once);
    }
    EXPECT_THAT(judged(), testing::IsEmpty());
}

TEST_F(PromisesTest, P2AnAcknowledgedMessageThatASubscriberNeverGot) {
    subscribed(Instant{0s});
    sent(1, Qos::at_least_once);
    EXPECT_THAT(judged(), testing::ElementsAre(Promise::nothing_lost));
}

TEST_F(PromisesTest, P2HoldsForThoseOnlyWhoWereSubscribedBefore) {
    subscribed(Instant{1500ms});
    sent(1, Qos::at_least_once);
    EXPECT_THAT(judged(), testing::IsEmpty());
}

TEST_F(PromisesTest, P2SaysNothingOfWhatWasNotAcknowledgedButItHasToBeAtTheEnd) {
    subscribed(Instant{0s});
    sent(1, Qos::at_least_once, false);
    EXPECT_THAT(judged(), testing::ElementsAre(Promise::liveness));
}

TEST_F(PromisesTest, P3AQos2MessageTwice) {
    sent(1, Qos::exactly_once);
    received(1, Qos::exactly_once);
    received(1, Qos::exactly_once);
    EXPECT_THAT(judged(), testing::ElementsAre(Promise::exactly_once));
}

TEST_F(PromisesTest, P5AnOlderMessageBehindANewerOne) {
    for (std::uint32_t number : {1U, 2U}) sent(number, Qos::at_least_once);
    received(2, Qos::at_least_once);
    received(1, Qos::at_least_once);
    EXPECT_THAT(judged(), testing::ElementsAre(Promise::in_order));
}

TEST_F(PromisesTest, P5AllowsQos1DuplicatesLate) {
    for (std::uint32_t number : {1U, 2U}) sent(number, Qos::at_least_once);
    received(1, Qos::at_least_once);
    received(2, Qos::at_least_once);
    received(1, Qos::at_least_once);
    EXPECT_THAT(judged(), testing::IsEmpty());
}

// Seeds 60194, 70287, 71993: asked for before the cut, said to both sides in it.
TEST_F(PromisesTest, P5IsNotJudgedForWhatWasUnderWayInACutThatClientsHearThrough) {
    for (std::uint32_t number : {1U, 2U}) sent(number, Qos::exactly_once);
    received(2, Qos::exactly_once);
    received(1, Qos::exactly_once);
    EXPECT_THAT(judged({{Instant{1500ms}, Instant{2500ms}}}), testing::IsEmpty());
    EXPECT_THAT(judged({{Instant{2100ms}, Instant{2500ms}}}),
                testing::ElementsAre(Promise::in_order));
}

TEST_F(PromisesTest, P7TheWillOfARobotThatLives) {
    ledger.wills.push_back({"listener", "talker", Instant{1s}, Qos::exactly_once});
    EXPECT_THAT(judged(), testing::ElementsAre(Promise::will_once));
}

TEST_F(PromisesTest, P7AWillTwice) {
    ledger.silenced["talker"] = Instant{0s};
    ledger.wills.push_back({"listener", "talker", Instant{1s}, Qos::exactly_once});
    ledger.wills.push_back({"listener", "talker", Instant{2s}, Qos::exactly_once});
    EXPECT_THAT(judged(), testing::ElementsAre(Promise::will_once));
    EXPECT_THAT(judged({{Instant{900ms}, Instant{1100ms}}}), testing::IsEmpty()) << "seed 415533";
}

}  // namespace
}  // namespace romano::sim::promises_test
