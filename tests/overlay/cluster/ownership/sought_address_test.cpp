// A broker whose own address nobody serves takes it, but not beside an heir that is about to.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::sought_address_test {
namespace {

using namespace two_brokers;

const LogId dead = test::log_of("dead");

/// In a view with the peer. The address was a dead broker's, who had inherited it.
struct Owner : InAView {
    Owner() { refuse(); }
    void install(std::vector<LogId> members, std::vector<Assignment> assignments) {
        View next{.number = core.view().number, .members = std::move(members)};
        ++next.number.count;
        std::ranges::sort(next.members);
        take(ViewAnnouncement{
            .view = std::move(next), .assignments = std::move(assignments), .ends = {{dead, 1}}});
        refuse();
    }
    /// Its machine was asked for the address in that time, and refused.
    bool takes_its_address_within(Duration time) {
        bool is_taken = false;
        for (const Instant end = now + time; now < end;) {
            hear();
            is_taken |= std::ranges::any_of(local, [](const LocalAction& action) {
                const auto* taken = std::get_if<TakeAddress>(&action);
                return taken != nullptr && taken->address == ours;
            });
            refuse();
        }
        return is_taken;
    }
    void refuse() {
        local.clear();
        core.on_address(effects(), ours, false);
    }
};

const Duration sought_within = test::times.addresses_sought_every() + test::times.beacon_every;

TEST(SoughtAddress, IsTakenWhenNobodyServesIt) {
    Owner owner;
    EXPECT_TRUE(owner.takes_its_address_within(sought_within));
}

// Its owner had come back under another heir that starved (simulator, faults `starve`, seed 1429).
TEST(SoughtAddress, I1_IsLeftToTheHeirThatAViewNames) {
    Owner owner;
    owner.install({self, peer}, {{{dead, 1}, ours, peer.broker}});
    EXPECT_FALSE(owner.takes_its_address_within(sought_within));
    // Nor is it forgotten in the next view, which has nothing to add.
    owner.install({self, peer}, {});
    EXPECT_FALSE(owner.takes_its_address_within(sought_within));
    EXPECT_EQ(owner.core.view().members.size(), 2U) << "the heir is a member still";
}

TEST(SoughtAddress, P1_IsTakenWhenTheHeirIsGone) {
    Owner owner;
    owner.install({self, peer}, {{{dead, 1}, ours, peer.broker}});
    owner.install({self}, {});
    EXPECT_TRUE(owner.takes_its_address_within(sought_within));
}

TEST(SoughtAddress, P1_IsTakenWhenALaterViewNamesTheOwner) {
    Owner owner;
    owner.install({self, peer}, {{{dead, 1}, ours, peer.broker}});
    owner.install({self, peer}, {{{dead, 1}, ours, self.broker}});
    EXPECT_TRUE(owner.takes_its_address_within(sought_within));
}

}  // namespace
}  // namespace romano::cluster::sought_address_test
