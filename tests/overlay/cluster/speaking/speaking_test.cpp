// What is said from an address leaves, waits or is dropped; what a client says is heard, or waits.
#include "overlay/cluster/speaking/speaking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::speaking_test {
namespace {

using namespace two_brokers;

using Fate = HeldOutput::Fate;

struct Speaker : InAView {
    Speaker() {
        serve(ours);
        EXPECT_EQ(speaking().said_from(now, ours), Fate::leaves);
        EXPECT_TRUE(speaking().is_open(ours));
    }
    [[nodiscard]] const Speaking& speaking() const { return core.speaking(); }
    /// "peer" answers on these, too.
    void hear_serving(std::vector<Endpoint> addresses) {
        take(Beacon{.name = "peer",
                    .log = peer,
                    .tick = ++ticks,
                    .hears = {self.broker},
                    .echoes = {{self, core.beacon(broker).tick}},
                    .home_addresses = {theirs},
                    .serving = std::move(addresses)});
    }
};

TEST(Speaking, I1_WithoutALeaseAllThatIsSaidOrHeardWaits) {
    Speaker speaker;
    speaker.now += 1s;
    EXPECT_FALSE(speaker.speaking().may_speak(speaker.now));
    EXPECT_EQ(speaker.speaking().said_from(speaker.now, ours), Fate::waits);
    const std::uint8_t pingreq[] = {2, 0x16};
    EXPECT_TRUE(speaker.speaking().must_wait(speaker.now, speaker.broker, ours, theirs, pingreq));
    EXPECT_FALSE(speaker.waits_for_session(ours, theirs));
}

// Its clients may have been served elsewhere, and are until that one knows of the view.
TEST(Speaking, I1_WhoHadNoLeaseIsSilentInTheNextViewUntilItHeardAllMembers) {
    Speaker speaker;
    const LogId third = test::log_of("third");
    const auto hear_third = [&] {
        speaker.take(Beacon{.name = "third",
                            .log = third,
                            .tick = ++speaker.ticks,
                            .hears = {self.broker},
                            .echoes = {{self, speaker.core.beacon(speaker.broker).tick}}});
    };
    View view{.number = {200, self.broker, 1}, .members = {self, peer, third}};
    std::ranges::sort(view.members);
    hear_third();
    speaker.take(ViewAnnouncement{.view = view, .assignments = {}, .ends = {}});
    hear_third();
    speaker.hear();
    ASSERT_TRUE(speaker.speaking().may_speak(speaker.now));

    while (speaker.core.membership().is_heard(third)) speaker.pass();
    ASSERT_TRUE(speaker.speaking().has_lost_lease(speaker.now));
    view.number.term = 300;
    speaker.take(ViewAnnouncement{.view = view, .assignments = {}, .ends = {}});
    ASSERT_EQ(speaker.core.view(), view);
    speaker.hear();
    EXPECT_FALSE(speaker.speaking().may_speak(speaker.now)) << "the third one was not heard";
    hear_third();
    EXPECT_TRUE(speaker.speaking().may_speak(speaker.now));
}

// Its clients would be answered from elsewhere, or from nowhere.
TEST(Speaking, P7_NothingLeavesFromAnInheritedAddressBeforeItIsHere) {
    Speaker heir;
    for (int i = 0; i < 100 && !heir.core.addresses().is_taking(theirs); ++i) heir.pass();
    ASSERT_TRUE(heir.core.addresses().is_taking(theirs));
    EXPECT_EQ(heir.speaking().said_from(heir.now, theirs), Fate::waits);
    EXPECT_FALSE(heir.speaking().is_open(theirs));
    heir.serve(theirs);
    EXPECT_EQ(heir.speaking().said_from(heir.now, theirs), Fate::leaves);
    EXPECT_TRUE(heir.speaking().is_open(theirs));
}

TEST(Speaking, I1_WhereARivalServesTheOwnAddressNothingIsSaidAndWhatIsHeardWaits) {
    Speaker owner;
    owner.hear_serving({theirs, ours});
    EXPECT_EQ(owner.speaking().said_from(owner.now, ours), Fate::is_dropped);
    EXPECT_FALSE(owner.speaking().is_open(ours));
    EXPECT_FALSE(owner.speaking().is_deaf(ours));
    EXPECT_TRUE(owner.waits_for_session(ours, test::address(99)));
}

TEST(Speaking, I1_WhereItsOwnerServesAnAddressNothingIsSaidOrHeard) {
    Speaker heir;
    for (int i = 0; i < 100 && !heir.core.addresses().is_taking(theirs); ++i) heir.pass();
    heir.serve(theirs);
    heir.hear_serving({theirs});
    EXPECT_EQ(heir.speaking().said_from(heir.now, theirs), Fate::is_dropped);
    EXPECT_TRUE(heir.speaking().is_deaf(theirs));
    EXPECT_FALSE(heir.speaking().is_open(theirs));
    EXPECT_EQ(heir.speaking().said_from(heir.now, ours), Fate::leaves);
}

// The other heir's copy of a session may be the newer one.
TEST(Speaking, P3_TheFirstHeirSaysAndHearsNothingBeforeTheOtherHasPassedOnItsSessions) {
    Speaker heir;
    const Endpoint left = test::address(3);
    ViewAnnouncement next{
        .view = {.number = {200, self.broker, 1}, .members = heir.core.view().members},
        .assignments = {{{test::log_of("third", 1), 1}, left, self.broker},
                        {{test::log_of("third", 2), 1}, left, peer.broker}}};
    heir.take(next);
    heir.serve(left);
    heir.hear();
    EXPECT_EQ(heir.speaking().said_from(heir.now, left), Fate::is_dropped);
    EXPECT_TRUE(heir.waits_for_session(left, test::address(99)));
    EXPECT_EQ(heir.speaking().said_from(heir.now, ours), Fate::leaves);
    heir.take(LogBatch{
        .log = peer, .first_seq = 1, .events = {broker::LogEvent{broker::Sealed{left, self}}}});
    heir.tick();
    EXPECT_EQ(heir.speaking().said_from(heir.now, left), Fate::leaves);
    EXPECT_FALSE(heir.waits_for_session(left, test::address(99)));
}

// I7: it may come back, and what its client says meanwhile would be a stranger's.
TEST(Speaking, I7_WhatAClientSaysWaitsUntilItsNewHomeHasItsSession) {
    Speaker former;
    auto session = image(1, ours);
    session.header.address.endpoint = test::address(99);
    (void)former.broker.adopt(former.now, session, {}, former.clients);
    former.keep_log();
    EXPECT_FALSE(former.waits_for_session(ours, test::address(99)));
    former.take(SessionRequest{client(1), theirs});
    EXPECT_TRUE(former.waits_for_session(ours, test::address(99)));
    EXPECT_FALSE(former.waits_for_session(ours, test::address(98))) << "another client";
    const LogPosition moved{self, former.broker.last_seq()};
    session.header.via = theirs;
    former.take(LogBatch{
        .log = peer,
        .first_seq = 1,
        .events = {broker::LogEvent{broker::SessionPut{.image = session, .adopted = moved}}}});
    EXPECT_FALSE(former.waits_for_session(ours, test::address(99)));
}

}  // namespace
}  // namespace romano::cluster::speaking_test
