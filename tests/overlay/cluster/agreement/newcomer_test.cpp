// A newcomer learns of logs before its first view: from what waited in its own queue, too, since
// before their writers died.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::newcomer_test {
namespace {

using namespace two_brokers;
using testing::ElementsAre;
using testing::IsEmpty;

const LogId dead = test::log_of("dead");

/// It hears the peer, which leads.
class Newcomer : public testing::Test {
protected:
    Newcomer() { hear_the_leader(); }
    /// It said so before it died.
    void hear_the_dead(std::vector<LogPosition> applied = {}) {
        Effects acting = cluster.effects();
        Beacon beacon{.name = "dead", .log = dead, .tick = 1, .hears = {self.broker}};
        beacon.applied = std::move(applied);
        hear(cluster.core, acting, beacon);
        cluster.core.on_message(acting, {dead, LogBatch{dead, 1, {test::session("robot")}}});
    }
    void hear_the_dead_no_more() {
        for (int beacon_time = 0; beacon_time < 20; ++beacon_time) hear_the_leader();
    }
    /// Its home address is held by the peer.
    bool takes_what_is_held() {
        cluster.local.clear();
        hear_the_leader({ours});
        return std::ranges::any_of(cluster.local, [](const LocalAction& action) {
            return std::holds_alternative<TakeAddress>(action);
        });
    }
    void hear_the_leader(std::vector<Endpoint> serving = {}) {
        Beacon leads{.name = "peer", .log = peer, .tick = ++ticks, .hears = {self.broker}};
        leads.serving = std::move(serving);
        leads.echoes = {{self, cluster.core.beacon(cluster.broker).tick}};
        leads.claim = {.rank = {.capability = 9, .id = node_of(peer.broker)},
                       .term = 5,
                       .leader = node_of(peer.broker)};
        leads.ended = ended;
        cluster.take(leads);
        cluster.pass();
    }
    View next_view(std::vector<LogId> members) {
        std::ranges::sort(members);
        return {.number = {.term = 5, .leader = peer.broker, .count = ++views},
                .members = std::move(members)};
    }
    /// What it tells the leader of a view that only the two of them are in.
    ViewHoldings answer() {
        hear_the_dead_no_more();
        cluster.peers.clear();
        cluster.take(ViewProposal{.view = next_view({self, peer}), .removed = {dead}});
        const auto sent = cluster.take_sent<ViewHoldings>();
        EXPECT_EQ(sent.size(), 1U);
        return sent.empty() ? ViewHoldings{} : sent.front();
    }

    Cluster cluster;
    std::vector<LogPosition> ended;  // as the leader says
    std::uint64_t ticks = 0;
    std::uint32_t views = 0;
};

// Others took care of its sessions (simulator, seed 8020270).
TEST_F(Newcomer, P3_KnowsOfNothingThatIsLeftOfALogFromBefore) {
    hear_the_dead();
    EXPECT_THAT(answer().outdated, ElementsAre(dead));
}

// A broker that had been replaced while it stood still gave its old log to a newcomer, and began
// anew; the newcomer went on from that beside the heir (simulator, as shipped, seed 18711).
TEST_F(Newcomer, P3_KnowsOfNothingThatIsLeftOfAWriterThatHeardIt) {
    hear_the_dead({{self, 0}});
    EXPECT_THAT(answer().outdated, ElementsAre(dead));
}

TEST_F(Newcomer, P3_KnowsOfNothingThatIsLeftOfAWriterThatItMetInAViewWithoutThat) {
    cluster.take(ViewAnnouncement{.view = next_view({self, peer})});
    hear_the_dead({{self, 0}});
    EXPECT_THAT(answer().outdated, ElementsAre(dead));
}

// From then on the writer counts what the newcomer holds as safe.
TEST_F(Newcomer, P2_KnowsWhatIsLeftOfAWriterWithWhichItPromisedAView) {
    hear_the_dead();
    cluster.take(ViewProposal{.view = next_view({self, peer, dead})});
    EXPECT_THAT(answer().outdated, IsEmpty());
}

// It stood still and did not know yet that it had been replaced; then its heir died (simulator,
// faults `relapse`, seed 1971).
TEST_F(Newcomer, P3_KnowsOfNothingThatIsLeftOfAWriterThatWasReplaced) {
    hear_the_dead();
    ended = {{dead, 0}};
    hear_the_leader();
    cluster.take(ViewProposal{.view = next_view({self, peer, dead})});
    EXPECT_THAT(answer().outdated, ElementsAre(dead));
}

TEST_F(Newcomer, P2_KnowsWhatIsLeftOfAWriterThatLivedOnInItsView) {
    hear_the_dead();
    ended = {{dead, 0}};
    hear_the_leader();
    cluster.take(ViewAnnouncement{.view = next_view({self, peer, dead})});
    EXPECT_THAT(answer().outdated, IsEmpty());
}

// P2: its clients were silent until it had met them (loops: 146 ms without a command).
TEST_F(Newcomer, TakesNoAddressBackBeforeItHasMetAllMembers) {
    const LogId third = test::log_of("third");
    View view{.number = {.term = 5, .leader = peer.broker, .count = 1},
              .members = {self, peer, third}};
    std::ranges::sort(view.members);
    cluster.take(ViewAnnouncement{.view = view});
    hear_the_leader();
    EXPECT_FALSE(takes_what_is_held());
    Beacon met{.name = "third", .log = third, .tick = 1, .hears = {self.broker}};
    met.echoes = {{self, cluster.core.beacon(cluster.broker).tick}};
    Effects acting = cluster.effects();
    hear(cluster.core, acting, met);
    hear_the_leader();
    EXPECT_TRUE(takes_what_is_held());
}

// What it promised alone would keep it from beginning anew when it is replaced.
TEST_F(Newcomer, P3_PromisesNothingBeforeItsFirstView) {
    cluster.core.append(1, test::published(self, 1));
    cluster.pass();
    ASSERT_TRUE(cluster.core.view().members.empty());
    EXPECT_EQ(cluster.core.safe(cluster.now), 0U);
}

}  // namespace
}  // namespace romano::cluster::newcomer_test
