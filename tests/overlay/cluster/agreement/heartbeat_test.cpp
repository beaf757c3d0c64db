#include "overlay/cluster/agreement/heartbeat.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "romano/base/random.h"
#include "tests/overlay/cluster/events.h"

namespace romano::cluster::heartbeat_test {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;
using testing::UnorderedElementsAreArray;

const LogId self = test::log_of("self");
const LogId peer = test::log_of("peer");
const LogId third = test::log_of("third");
const LogId stranger = test::log_of("stranger");

View view_of(std::uint64_t count, std::vector<LogId> members) {
    std::ranges::sort(members);
    return {.number = {.term = 1, .leader = peer.broker, .count = count},
            .members = std::move(members)};
}

struct HeartbeatTest : testing::Test {
    HeartbeatTest() {
        beacon.hears = {self.broker, third.broker};
        beacon.applied = {{self, 3}, {third, 5}};
        std::ranges::sort(beacon.applied);
    }
    /// The next one; lost, perhaps.
    const Beacon* say(bool is_lost = false) {
        ++beacon.tick;
        const Heartbeat heartbeat = writer.write(beacon);
        octets_of_places = heartbeat.hears_members.size();
        named = heartbeat.hears_others.size() + heartbeat.held_others.size();
        return is_lost ? nullptr : hear(heartbeat);
    }
    const Beacon* hear(const Heartbeat& heartbeat) {
        return reader.read(heartbeat, last_of(heartbeat.log), own_view, own_tick) ? &*last
                                                                                  : nullptr;
    }
    const Beacon* tell() { return tell(Particulars{beacon}); }
    const Beacon* tell(const Particulars& particulars) {
        auto joined = reader.read(particulars, last_of(particulars.beacon.log), own_view);
        if (!joined) return nullptr;
        last = *std::move(joined);
        return &*last;
    }
    /// Of that life of the peer.
    Beacon* last_of(const LogId& log) { return last && last->log == log ? &*last : nullptr; }
    /// What the reader believes is what the writer says.
    void expect_equal(const Beacon* read) const {
        ASSERT_NE(read, nullptr);
        EXPECT_EQ(read->log, beacon.log);
        EXPECT_EQ(read->tick, beacon.tick);
        EXPECT_EQ(read->last_seq, beacon.last_seq);
        EXPECT_EQ(read->view, beacon.view);
        EXPECT_EQ(read->claim, beacon.claim);
        EXPECT_THAT(read->hears, UnorderedElementsAreArray(beacon.hears));
        EXPECT_EQ(read->applied, beacon.applied);
        EXPECT_EQ(read->serving, beacon.serving);
        EXPECT_EQ(read->leaving, beacon.leaving);
    }
    [[nodiscard]] bool must_ask() {
        return reader.must_ask(now += 1s, test::times.particulars_asked_again_after(), peer.broker);
    }

    HeartbeatWriter writer;
    HeartbeatReader reader{self.broker};
    std::optional<Beacon> last;  // as Membership keeps it
    View own_view = view_of(1, {self, peer, third});
    std::uint64_t own_tick = 0;  // the newest that the peer may have heard
    Beacon beacon{.name = "peer", .log = peer, .view = view_of(1, {self, peer, third})};
    std::size_t octets_of_places = 0;
    std::size_t named = 0;
    Instant now{1s};
};

TEST_F(HeartbeatTest, OfOneWhoseParticularsAreUnknownSaysNothingAndIsAskedAfter) {
    EXPECT_EQ(say(), nullptr);
    EXPECT_TRUE(must_ask());
    expect_equal(tell());
    EXPECT_FALSE(must_ask());
    expect_equal(say());
}

TEST_F(HeartbeatTest, IsAskedAgainWhenNoAnswerComesButNotAtOnce) {
    say();
    EXPECT_TRUE(reader.must_ask(now, 20ms, peer.broker));
    EXPECT_FALSE(reader.must_ask(now + 19ms, 20ms, peer.broker));
    EXPECT_TRUE(reader.must_ask(now + 20ms, 20ms, peer.broker));
}

TEST_F(HeartbeatTest, InOneViewNobodyIsNamed) {
    say();
    EXPECT_EQ(octets_of_places, 1U);
    EXPECT_EQ(named, 0U);
}

TEST_F(HeartbeatTest, OneInTheReadersViewNeedsNotSayWhoIsInIt) {
    say();
    tell();
    own_view = beacon.view = view_of(2, {self, peer});
    beacon.hears = {self.broker};
    expect_equal(say());
    EXPECT_FALSE(must_ask());
}

TEST_F(HeartbeatTest, OfAnotherViewIsUnderstoodWhenTheParticularsAreHere) {
    say();
    tell();
    beacon.view = view_of(2, {peer, third});  // we are left out
    beacon.hears = {third.broker};
    const Beacon* read = say();
    ASSERT_NE(read, nullptr) << "it lives";
    EXPECT_NE(read->view, beacon.view) << "who is in it is not known";
    EXPECT_FALSE(reader.is_complete(peer.broker));
    ASSERT_TRUE(must_ask());
    expect_equal(tell());
    EXPECT_TRUE(reader.is_complete(peer.broker));
    expect_equal(say());
}

// It was replaced, and still knows the number of its last view: nobody is in a view with it.
TEST_F(HeartbeatTest, OneInNoViewNamesWhomItHears) {
    say();
    tell();
    beacon.view.members.clear();
    expect_equal(say());
    EXPECT_FALSE(must_ask());
    own_view.members.clear();
    beacon.view.members = view_of(1, {self, peer, third}).members;
    ASSERT_NE(say(), nullptr);
    EXPECT_TRUE(must_ask()) << "who is in that view is not known where nobody is in one";
    expect_equal(tell());
}

// Particulars say whom the sender hears as of their own tick.
TEST_F(HeartbeatTest, WhomItHearsIsReadAnewAfterParticulars) {
    say();
    tell();
    say();
    Particulars other{beacon};
    ++other.beacon.tick;
    other.beacon.hears = {};
    ASSERT_THAT(tell(other)->hears, IsEmpty());
    ++beacon.tick;
    expect_equal(say());
}

TEST_F(HeartbeatTest, VouchersAreReadWithTheMembersOfTheView) {
    say();
    tell();
    beacon.vouched = {self.broker, third.broker};
    EXPECT_THAT(say()->vouched, UnorderedElementsAreArray(beacon.vouched));
    beacon.vouched = {third.broker};
    EXPECT_THAT(say()->vouched, UnorderedElementsAreArray(beacon.vouched));
    EXPECT_THAT(say()->vouched, UnorderedElementsAreArray(beacon.vouched));
    own_view = beacon.view = view_of(2, {peer, self, stranger});
    beacon.vouched = {stranger.broker};
    EXPECT_THAT(say()->vouched, UnorderedElementsAreArray(beacon.vouched));
}

TEST_F(HeartbeatTest, WhatIsServedChangesTheDigest) {
    say();
    tell();
    beacon.serving = {test::address(1)};
    say();
    EXPECT_TRUE(writer.has_news());
    EXPECT_TRUE(must_ask());
    expect_equal(tell());
    say();
    EXPECT_FALSE(writer.has_news());
}

TEST_F(HeartbeatTest, ALogThatIsHeldNoMoreIsForgotten) {
    say();
    tell();
    std::erase_if(beacon.applied, [](const auto& held) { return held.log == third; });
    bool is_asked = false;
    for (int i = 0; i < 100 && !is_asked; ++i) {
        say();
        is_asked = must_ask();
    }
    ASSERT_TRUE(is_asked);
    expect_equal(tell());
}

TEST_F(HeartbeatTest, ParticularsThatWaitedTakeNothingBackThatCameSince) {
    say();
    tell();
    const Particulars late{beacon};
    beacon.applied.front().seq += 7;
    say();
    expect_equal(tell(late) == nullptr ? nullptr : say());
}

TEST_F(HeartbeatTest, OfAnEarlierLifeIsNotHeeded) {
    say();
    tell();
    const Heartbeat old{.log = {peer.broker, peer.incarnation - 1}, .tick = 1'000};
    EXPECT_EQ(hear(old), nullptr);
    EXPECT_EQ(tell(Particulars{{.log = old.log, .tick = 1'000}}), nullptr);
    expect_equal(say());
}

TEST_F(HeartbeatTest, ALaterLifeIsAnotherOne) {
    say();
    tell();
    beacon.log.incarnation += 1;
    beacon.tick = 0;
    writer = {};
    EXPECT_EQ(say(), nullptr);
    EXPECT_TRUE(must_ask());
    expect_equal(tell());
}

TEST_F(HeartbeatTest, NoOctetsFromAPeerBreakIt) {
    say();
    tell();
    Heartbeat strange{.log = peer, .tick = ++beacon.tick, .view = own_view.number, .members = 3};
    strange.hears_members.assign(1'000, 0xFF);
    strange.held = {{0, 1}, {4'000'000'000, 2}};
    const Beacon* read = hear(strange);
    ASSERT_NE(read, nullptr);
    EXPECT_EQ(read->hears.size(), own_view.members.size());
}

// Whatever is lost: when nothing changes any more the reader has all that the writer says.
TEST_F(HeartbeatTest, LossIsMadeUpFor) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random{seed};
        writer = {};
        reader = HeartbeatReader{self.broker};
        last.reset();
        beacon = {.name = "peer", .log = peer, .view = view_of(1, {self, peer, third})};
        for (int host = 0; host < 20; ++host) {
            beacon.applied.push_back({test::log_of("b" + std::to_string(host)), 1});
        }
        std::ranges::sort(beacon.applied);
        const Beacon* read = nullptr;
        const auto exchange = [&](bool is_lossy) {
            const bool is_lost = is_lossy && random.below(3) == 0;
            if (const Beacon* news = say(is_lost)) read = news;
            if (must_ask() && !(is_lossy && random.below(3) == 0)) {
                if (const Beacon* news = tell()) read = news;
            }
        };
        for (int i = 0; i < 100; ++i) {
            ++beacon.applied[random.below(static_cast<std::uint32_t>(beacon.applied.size()))].seq;
            if (random.below(10) == 0) beacon.serving = {test::address(i)};
            if (random.below(10) == 0) {
                beacon.view = view_of(random.below(3), {self, peer, stranger});
            }
            if (random.below(10) == 0) own_view = view_of(random.below(3), {self, peer, stranger});
            exchange(true);
        }
        for (int i = 0; i < 20; ++i) exchange(false);
        expect_equal(read);
    }
}

}  // namespace
}  // namespace romano::cluster::heartbeat_test
