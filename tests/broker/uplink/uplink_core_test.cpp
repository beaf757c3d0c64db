// What goes over the uplink and what comes in, decided without I/O.

#include "broker/uplink/uplink_core.h"

#include <gmock/gmock.h>

namespace romano::uplink::uplink_core_test {
namespace {

using broker::Delivery;
using broker::LogId;
using broker::LogPosition;
using broker::Message;
using broker::MessagePtr;
using mqttsn::Qos;
using testing::ElementsAre;
using testing::IsEmpty;

const LogId own{broker::broker_id_of("r1"), 7};
const LogId peer{broker::broker_id_of("r2"), 8};
const LogPosition all_safe{own, 1'000'000};

Delivery waiting(const LogPosition& position, const std::string& topic = "fleet/a") {
    return {.position = position,
            .message = MessagePtr{Message{.topic = topic,
                                          .payload = {1},
                                          .qos = Qos::exactly_once,
                                          .retain = false,
                                          .position = position,
                                          .published_at = {}}},
            .qos = Qos::exactly_once};
}

FromRemote from_remote(const std::string& identity, std::uint16_t packet_id = 1,
                       std::uint8_t octet = 1) {
    return {.topic = "fleet/a",
            .payload = {octet},
            .qos = Qos::at_least_once,
            .retain = false,
            .identity = identity,
            .packet_id = packet_id};
}

struct Uplink : testing::Test {
    static UplinkOptions options() {
        return {.network = "site-a", .rules = {parse_rule("fleet/#").value()}};
    }
    /// The identities of what was sent.
    std::vector<std::string> sent() {
        std::vector<std::string> identities;
        for (const auto& action : out) {
            if (const auto* up = std::get_if<PublishUp>(&action)) {
                identities.push_back(up->identity);
            }
        }
        out.clear();
        return identities;
    }
    void connect(bool resumed = true) {
        core.hold(true, out);
        core.on_up(resumed);
        out.clear();
    }
    /// As the member does: what is taken is published, and so remembered.
    bool takes(const FromRemote& message) {
        const auto inbound = core.receive(message);
        if (inbound) core.remember(inbound->origin);
        return inbound.has_value();
    }

    UplinkCore core{options(), 0x11};
    std::vector<UplinkAction> out;
};

TEST_F(Uplink, OnlyWhoHoldsTheLinkOpensItAndLetsItGo) {
    core.hold(false, out);
    EXPECT_THAT(out, IsEmpty());
    core.hold(true, out);
    core.hold(true, out);
    core.hold(false, out);
    ASSERT_EQ(out.size(), 2U);
    EXPECT_TRUE(std::holds_alternative<OpenLink>(out[0]));
    EXPECT_TRUE(std::holds_alternative<CloseLink>(out[1]));
}

TEST_F(Uplink, SendsNothingBeforeTheLinkIsUp) {
    const std::vector queue{waiting({peer, 1})};
    core.send(queue, all_safe, out);
    core.hold(true, out);
    out.clear();
    core.send(queue, all_safe, out);
    EXPECT_THAT(sent(), IsEmpty());
    core.on_up(true);
    core.send(queue, all_safe, out);
    EXPECT_EQ(sent().size(), 1U);
}

TEST_F(Uplink, IdentityNamesNetworkLogAndPlaceWhoeverSendsIt) {
    connect();
    core.send(std::vector{waiting({peer, 12})}, all_safe, out);
    const auto first = sent();
    UplinkCore heir{options(), 0x22};
    heir.hold(true, out);
    heir.on_up(true);
    heir.send(std::vector{waiting({peer, 12})}, all_safe, out);
    EXPECT_EQ(sent(), first);
    EXPECT_THAT(first[0], testing::StartsWith("site-a/"));
    EXPECT_THAT(first[0], testing::EndsWith(".8/12"));
}

TEST_F(Uplink, SendsEachMessageOnceWhileItWaits) {
    connect();
    const std::vector queue{waiting({peer, 1}), waiting({peer, 2})};
    core.send(queue, all_safe, out);
    EXPECT_EQ(sent().size(), 2U);
    core.send(queue, all_safe, out);
    EXPECT_THAT(sent(), IsEmpty());
}

TEST_F(Uplink, KeepsTheWindow) {
    connect();
    std::vector<Delivery> queue;
    for (std::uint64_t i = 1; i <= 100; ++i) queue.push_back(waiting({peer, i}));
    core.send(queue, all_safe, out);
    EXPECT_EQ(sent().size(), UplinkCore::window);
    core.on_answer({peer, 1}, Answer::done);
    queue.erase(queue.begin());
    core.send(queue, all_safe, out);
    EXPECT_EQ(sent().size(), 1U);
}

TEST_F(Uplink, WhatIsNotTakenGoesAgainWhenTheOthersAreAnswered) {
    connect();
    std::vector queue{waiting({peer, 1}), waiting({peer, 2})};
    core.send(queue, all_safe, out);
    const auto first = sent();
    core.on_answer({peer, 1}, Answer::busy);
    queue.push_back(waiting({peer, 3}));
    core.send(queue, all_safe, out);
    EXPECT_THAT(sent(), IsEmpty()) << "it would be refused as well, or pass the one that was";
    core.on_answer({peer, 2}, Answer::done);
    queue.erase(queue.begin() + 1);
    core.send(queue, all_safe, out);
    const auto again = sent();
    ASSERT_EQ(again.size(), 2U);
    EXPECT_EQ(again[0], first[0]);
    EXPECT_EQ(core.counters().busy, 1U);
}

TEST_F(Uplink, WhatIsNotSafeYetWaits) {
    connect();
    const std::vector queue{waiting({own, 1}), waiting({own, 2})};
    core.send(queue, {own, 1}, out);
    EXPECT_EQ(sent().size(), 1U);
    core.send(queue, {own, 2}, out);
    EXPECT_EQ(sent().size(), 1U);
}

TEST_F(Uplink, AfterALostConnectionTheLibraryRepeatsAndNotWe) {
    connect();
    const std::vector queue{waiting({peer, 1})};
    core.send(queue, all_safe, out);
    core.on_down();
    core.on_up(true);
    out.clear();
    core.send(queue, all_safe, out);
    EXPECT_THAT(sent(), IsEmpty());
}

TEST_F(Uplink, ANewTimeAsLeaderBeginsWithWhatStillWaits) {
    connect();
    const std::vector queue{waiting({peer, 1})};
    core.send(queue, all_safe, out);
    const auto first = sent();
    core.hold(false, out);
    connect();
    core.send(queue, all_safe, out);
    EXPECT_EQ(sent(), first);
}

TEST_F(Uplink, WhatNoRuleSendsAnyMoreIsDiscarded) {
    connect();
    core.send(std::vector{waiting({peer, 1}, "elsewhere")}, all_safe, out);
    ASSERT_EQ(out.size(), 1U);
    EXPECT_EQ(std::get<Discard>(out[0]).position, (LogPosition{peer, 1}));
}

TEST_F(Uplink, Qos0GoesNowOrNever) {
    const auto message = waiting({peer, 0}).message;
    core.hold(true, out);
    out.clear();
    core.send_now(message, out);
    EXPECT_THAT(sent(), IsEmpty());
    EXPECT_EQ(core.counters().dropped, 1U);
    core.on_up(true);
    core.send_now(message, out);
    EXPECT_EQ(sent().size(), 1U);
}

TEST_F(Uplink, AnIdentityComesInOnce) {
    connect();
    EXPECT_TRUE(takes(from_remote("site-b/1.2/3", 1)));
    EXPECT_FALSE(takes(from_remote("site-b/1.2/3", 2)));
    EXPECT_TRUE(takes(from_remote("site-b/1.2/4", 3)));
    EXPECT_EQ(core.counters().duplicates, 1U);
}

TEST_F(Uplink, WhatAPeerPublishedIsKnownToTheNextLeader) {
    core.remember("site-b/1.2/3");
    connect();
    EXPECT_FALSE(takes(from_remote("site-b/1.2/3")));
}

TEST_F(Uplink, OurOwnMessagesDoNotComeBack) {
    connect();
    EXPECT_FALSE(takes(from_remote("site-a/1.2/3")));
    EXPECT_TRUE(takes(from_remote("site-ab/1.2/3")));
    EXPECT_EQ(core.counters().own, 1U);
}

TEST_F(Uplink, WithoutAnIdentityTheSessionThePacketIdAndTheContentsTell) {
    connect(false);
    EXPECT_TRUE(takes(from_remote("", 1)));
    core.on_up(true);
    EXPECT_FALSE(takes(from_remote("", 1)));
    EXPECT_TRUE(takes(from_remote("", 2)));
    core.on_up(true);
    EXPECT_TRUE(takes(from_remote("", 1, 9)));
}

TEST_F(Uplink, APacketIdThatIsUsedAgainOnTheSameConnectionIsOfANewMessage) {
    connect(false);
    EXPECT_TRUE(takes(from_remote("", 1, 1)));
    EXPECT_TRUE(takes(from_remote("", 1, 2)));
    EXPECT_TRUE(takes(from_remote("", 1, 1)));
    EXPECT_TRUE(takes(from_remote("", 1, 1)));
    core.on_up(true);
    EXPECT_FALSE(takes(from_remote("", 1, 1))) << "its answer was lost with the connection";
    EXPECT_TRUE(takes(from_remote("", 1, 1)));
    EXPECT_EQ(core.counters().duplicates, 1U);
}

TEST_F(Uplink, OnlyWhatCameLastUnderAPacketIdIsRepeated) {
    connect(false);
    EXPECT_TRUE(takes(from_remote("", 1, 1)));
    EXPECT_TRUE(takes(from_remote("", 1, 2)));
    core.on_up(true);
    EXPECT_TRUE(takes(from_remote("", 1, 1)));
    core.on_up(true);
    EXPECT_FALSE(takes(from_remote("", 1, 1)));
}

TEST_F(Uplink, ANewSessionAtTheMqttBrokerCountsAnew) {
    connect(false);
    EXPECT_TRUE(takes(from_remote("", 1)));
    core.on_up(false);
    EXPECT_TRUE(takes(from_remote("", 1)));
}

TEST_F(Uplink, TheNextLeaderKnowsARepetitionOfTheSameSession) {
    connect(false);
    const auto inbound = core.receive(from_remote("", 1));
    ASSERT_TRUE(inbound);
    UplinkCore heir{options(), 0x22};
    heir.remember(inbound->origin);  // from its predecessor's log
    heir.hold(true, out);
    heir.on_up(true);
    EXPECT_FALSE(heir.receive(from_remote("", 1)));
    EXPECT_TRUE(heir.receive(from_remote("", 2)));
}

TEST_F(Uplink, Qos0WithoutAnIdentityIsNeverARepetition) {
    connect();
    EXPECT_TRUE(takes(from_remote("", 0)));
    EXPECT_TRUE(takes(from_remote("", 0)));
}

TEST_F(Uplink, AnIdentityThatNobodyMayHaveIsNone) {
    connect(false);
    EXPECT_TRUE(takes(from_remote(std::string(1000, 'x'), 1)));
    EXPECT_TRUE(takes(from_remote("~forged/1-2", 2)));
    core.on_up(true);
    EXPECT_FALSE(takes(from_remote("~forged/3-4", 2)));  // the same packet again
}

TEST_F(Uplink, WhatFitsNoRuleStaysOut) {
    connect();
    auto message = from_remote("site-b/1.2/3");
    message.topic = "private";
    EXPECT_FALSE(takes(message));
    EXPECT_EQ(core.counters().unwanted, 1U);
}

TEST(SeenIdentitiesTest, ForgetTheOldest) {
    SeenIdentities seen;
    EXPECT_TRUE(seen.add("first"));
    for (std::size_t i = 0; i < SeenIdentities::most; ++i) seen.add(std::to_string(i));
    EXPECT_FALSE(seen.contains("first"));
    EXPECT_TRUE(seen.contains("0"));
}

}  // namespace
}  // namespace romano::uplink::uplink_core_test
