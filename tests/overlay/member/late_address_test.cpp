// A member whose machine takes long to take an address, beside two others that the test speaks for.

#include <gtest/gtest.h>

#include "overlay/member/member.h"
#include "tests/overlay/cluster/events.h"
#include "tests/overlay/member/brokers.h"

namespace romano::test::late_address_test {
namespace {

using namespace std::chrono_literals;

class LateAddress : public testing::Test {
protected:
    LateAddress() {
        while (!member.cluster().leadership().leader) hear_others();
        cluster::ViewAnnouncement announcement{
            .view = {.number = {100, self.broker, 1}, .members = {self, giver, third}}};
        std::ranges::sort(announcement.view.members);
        take(giver, announcement);
        hear_others();
    }

    void take(const broker::LogId& from, cluster::ClusterMessage message) {
        member.on_peer_message(now, {from, std::move(message)}, actions);
        actions = {};
    }
    /// A beacon's interval later.
    void hear_others() {
        now += 10ms;
        ++ticks;
        for (const broker::LogId& other : {giver, third}) {
            const cluster::Beacon beacon{
                .log = other,
                .tick = ticks,
                .hears = {self.broker},
                .echoes = {{self, member.cluster().beacon(member.broker()).tick}}};
            cluster::HeartbeatWriter writer;
            take(other, writer.write(beacon));
            take(other, cluster::Particulars{beacon});
        }
        member.on_tick(now, actions);
        actions = {};
    }
    /// Of a client that heard publishes of the third one which are not here yet.
    void be_given_a_session() {
        auto put = std::get<broker::SessionPut>(session("robot", broker_address(1)));
        put.image.worked_through = {{third, 7}};
        take(giver,
             cluster::LogBatch{.log = giver, .first_seq = 1, .events = {put, moved(put, self)}});
    }

    const broker::LogId self = log_of("self");
    const broker::LogId giver = log_of("giver");
    const broker::LogId third = log_of("third");
    overlay::Member member{{.broker = {},
                            .cluster = {},
                            .name = "self",
                            .incarnation = 1,
                            .home_addresses = {broker_address(1)}},
                           1};
    overlay::MemberActions actions;
    Instant now{10s};
    std::uint64_t ticks = 0;
};

TEST_F(LateAddress, P2_ASessionIsAdoptedWhenItHasWaitedLongEnough) {
    be_given_a_session();
    EXPECT_EQ(member.broker().session_count(), 0U);
    for (int beacons = 0; beacons < 50; ++beacons) hear_others();
    EXPECT_EQ(member.broker().session_count(), 1U);
}

// Its home took it back meanwhile.
TEST_F(LateAddress, P3_ASessionIsNotAdoptedByWhoStoodStillWhileItTookAnAddress) {
    be_given_a_session();
    now += 1s;
    member.on_address(now, broker_address(1), true, actions);
    EXPECT_EQ(member.broker().session_count(), 0U);
}

}  // namespace
}  // namespace romano::test::late_address_test
