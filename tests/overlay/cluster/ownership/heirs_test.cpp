#include "overlay/cluster/ownership/heirs.h"

#include <gmock/gmock.h>

#include "tests/overlay/cluster/events.h"

namespace romano::cluster::heirs_test {
namespace {

using namespace std::chrono_literals;
using test::address;
using testing::ElementsAre;
using testing::IsEmpty;

// b1 leads b1, b2, b3; b9 is dead.
class Heirs : public testing::Test {
protected:
    Heirs() {
        view.members = {b1, b2, b3};
        std::ranges::sort(view.members);
        beacon(b2, {});
        beacon(b3, {});
    }

    void beacon(const LogId& log, std::vector<Endpoint> served, std::uint32_t sessions = 0,
                std::vector<Endpoint> owned = {}) {
        Beacon said{.log = log, .tick = ++ticks, .hears = {b1.broker}};
        said.serving = std::move(served);
        said.home_addresses = std::move(owned);
        said.sessions = sessions;
        (void)membership.on_beacon(Instant{1s}, said);
    }
    void holds(const LogId& member, Seq seq, const std::vector<Endpoint>& addresses = {}) {
        ViewHoldings& answer = holdings[member];
        answer.holds.push_back({dead, seq});
        for (const Endpoint& left : addresses) answer.addresses.push_back({dead, left});
    }
    Answers answers() {
        return {.view = view,
                .holdings = holdings,
                .serving = serving,
                .home = home,
                .appointed = appointed,
                .ended = ended,
                .leader = b1,
                .leader_sessions = 5};
    }
    BrokerId heir_of(const Endpoint& left) {
        for (const auto& assignment : assign(answers(), agreed_ends(answers()), membership)) {
            if (assignment.address == left) return assignment.heir;
        }
        return {};
    }

    const LogId b1 = test::log_of("b1");
    const LogId b2 = test::log_of("b2");
    const LogId b3 = test::log_of("b3");
    const LogId dead = test::log_of("b9");
    Membership membership{ClusterOptions{}, b1.broker, 1};
    View view;
    std::map<LogId, ViewHoldings> holdings;
    std::vector<Endpoint> serving;
    std::vector<Endpoint> home;
    Appointed appointed;
    std::vector<LogPosition> ended;
    std::uint64_t ticks = 0;
};

TEST_F(Heirs, TheAgreedEndIsTheLastEventThatAnybodyHolds) {
    holds(b1, 5);
    holds(b2, 9);
    holds(b3, 7);
    EXPECT_EQ(agreed_ends(answers()).at(dead), 9U);
}

// It has adopted the sessions, and the leader has not heard of it (simulator, seed 990523).
// P3: a client that was not answered said the last publish again, to the heir.
TEST_F(Heirs, P3_WhatOnlyAReplacedMemberHoldsIsBeyondTheEnd) {
    holds(b1, 5);
    holds(b2, 9);
    holds(b3, 4);
    holdings[b2].outdated.push_back(dead);
    const auto ends = agreed_ends(answers());
    EXPECT_THAT(ends, ElementsAre(std::pair{dead, Seq{5}}));
    const auto tails = missing_tails(answers(), ends);
    ASSERT_EQ(tails.size(), 1U);
    EXPECT_EQ(tails[0].first, b1.broker);
    EXPECT_EQ(tails[0].second.to, b3.broker);
}

TEST_F(Heirs, P2_AReplacedMemberIsBelievedWhenNobodyElseHoldsAsMuch) {
    holds(b1, 0);
    holds(b2, 2'000);
    holds(b3, 100);  // it was cut off
    holdings[b2].outdated.push_back(dead);
    EXPECT_THAT(agreed_ends(answers()), ElementsAre(std::pair{dead, Seq{2'000}}));
}

// It comes back to those who came later, and were told where the others had gone on from
// (simulator, faults `relapse`, seed 9881208).
TEST_F(Heirs, P3_WhatTheLeaderWasToldEndsALogThatOnlyAReplacedMemberHolds) {
    holds(b2, 9);
    ended = {{dead, 5}};
    EXPECT_THAT(agreed_ends(answers()), ElementsAre(std::pair{dead, Seq{9}}));
    holdings[b2].outdated.push_back(dead);
    EXPECT_THAT(agreed_ends(answers()), ElementsAre(std::pair{dead, Seq{5}}));
}

TEST_F(Heirs, AnAddressGoesToOneWhoseMachineCanServeIt) {
    holds(b1, 5, {address(9)});
    holds(b2, 5);
    holds(b3, 5);
    holdings[b1].cannot_take.push_back(address(9));
    holdings[b3].cannot_take.push_back(address(9));
    beacon(b2, {}, 1'000);
    EXPECT_EQ(heir_of(address(9)), b2.broker) << "though the others have less to do";
}

TEST_F(Heirs, WhereNoMachineCanServeItTheSessionsHaveAnHeirAllTheSame) {
    holds(b1, 5, {address(9)});
    for (const LogId& member : {b1, b2, b3}) holdings[member].cannot_take.push_back(address(9));
    EXPECT_EQ(heir_of(address(9)), b1.broker);
}

TEST_F(Heirs, NobodyInheritsToWhomTheTopicIdsMeanSomethingElse) {
    holds(b1, 5, {address(9)});
    holds(b2, 5);
    holds(b3, 5);
    holdings[b1].foreign.push_back(dead);
    holdings[b2].foreign.push_back(dead);
    EXPECT_EQ(heir_of(address(9)), b3.broker);
    holdings[b3].foreign.push_back(dead);
    EXPECT_THAT(assign(answers(), agreed_ends(answers()), membership), IsEmpty());
}

TEST_F(Heirs, P3_WhoWasGivenTheAddressByTheLastViewKeepsIt) {
    holds(b1, 5, {address(9)});
    holds(b2, 5);
    holds(b3, 5, {address(9)});
    beacon(b2, {}, 100);  // not the least loaded one
    EXPECT_NE(heir_of(address(9)), b2.broker);
    appointed = {{address(9), b2}};
    EXPECT_EQ(heir_of(address(9)), b2.broker);
    beacon(b3, {address(9)});
    EXPECT_EQ(heir_of(address(9)), b3.broker) << "or who says that it serves it";
    beacon(b3, {});
    appointed = {{address(9), test::log_of("b2", 0)}};
    EXPECT_NE(heir_of(address(9)), b2.broker) << "that was a former life";
}

// P3: it had adopted the sessions and sent what waited there, and the leader had not heard of it;
// so the leader, as another heir, gave what was left in its eyes to the owner (simulator, seed
// 9755735).
TEST_F(Heirs, P3_WhoWasGivenTheAddressKeepsItWhenItsOwnBrokerIsBack) {
    holds(b1, 5, {address(9)});
    holds(b2, 5);
    beacon(b2, {}, 100);  // not the least loaded one
    beacon(b3, {address(9)}, 0, {address(9)});
    appointed = {{address(9), b2}};
    EXPECT_EQ(heir_of(address(9)), b2.broker);
    appointed = {};
    beacon(b2, {address(9)}, 100);
    EXPECT_EQ(heir_of(address(9)), b2.broker) << "or who serves it beside its owner";
}

TEST_F(Heirs, WhoLacksTheTailGetsItFromOneThatHasIt) {
    holds(b1, 5);
    holds(b2, 9);
    holds(b3, 9);
    const auto requests = missing_tails(answers(), agreed_ends(answers()));
    ASSERT_EQ(requests.size(), 1U);
    EXPECT_NE(requests[0].first, b1.broker);
    EXPECT_EQ(requests[0].second.to, b1.broker);
    EXPECT_EQ(requests[0].second.after, (LogPosition{dead, 5}));
}

TEST_F(Heirs, TheLeastLoadedInherits) {
    beacon(b2, {}, 3);
    beacon(b3, {}, 1);
    for (const LogId& member : view.members) holds(member, 9, {address(9)});
    EXPECT_EQ(heir_of(address(9)), b3.broker);
}

// What it lacks may be kept by nobody.
TEST_F(Heirs, P2_WhoWasCutOffAndIsFarBehindInheritsNothing) {
    beacon(b2, {}, 3);
    beacon(b3, {}, 1);
    holds(b1, 1'000, {address(9)});
    holds(b2, 1'000);
    holds(b3, 700);
    EXPECT_EQ(heir_of(address(9)), b2.broker);
    beacon(b3, {address(9)});
    EXPECT_EQ(heir_of(address(9)), b2.broker) << "though it serves the address";
}

// It holds the log from a snapshot, and none of the events before that: who lacks some of them
// waited for them in vain, and went on without the exchanges that they had ended (simulator, faults
// `relapse`, seeds 9850621 and 9851157).
TEST_F(Heirs, P3_WhoLacksATailThatNobodyCanSendInheritsNothing) {
    holds(b1, 9, {address(9)});
    holds(b2, 5);
    beacon(b2, {address(9)});
    EXPECT_EQ(heir_of(address(9)), b2.broker);
    EXPECT_EQ(missing_tails(answers(), agreed_ends(answers())).size(), 1U);
    holdings[b1].kept_after = {{dead, 6}};
    EXPECT_EQ(heir_of(address(9)), b1.broker);
    EXPECT_THAT(missing_tails(answers(), agreed_ends(answers())), IsEmpty());
    holds(b3, 9);
    EXPECT_EQ(heir_of(address(9)), b2.broker) << "another one can";
    EXPECT_EQ(missing_tails(answers(), agreed_ends(answers()))[0].first, b3.broker);
}

TEST_F(Heirs, SeveralAddressesAreSharedOut) {
    beacon(b2, {}, 5);
    beacon(b3, {}, 5);
    for (const LogId& member : view.members) holds(member, 9, {address(7), address(8), address(9)});
    EXPECT_NE(heir_of(address(7)), heir_of(address(8)));
    EXPECT_NE(heir_of(address(8)), heir_of(address(9)));
}

// It has begun to serve it, and the leader has not heard of it.
TEST_F(Heirs, I1_AnAddressStaysWithOneThatSaysInItsAnswerThatItServesIt) {
    for (const LogId& member : {b1, b2, b3}) holds(member, 5, {address(9)});
    beacon(b3, {}, 50);
    ASSERT_NE(heir_of(address(9)), b3.broker);
    holdings[b3].serving = {address(9)};
    EXPECT_EQ(heir_of(address(9)), b3.broker);
}

// Each of two heirs would give the IP address to its machine, and call the robots to itself.
TEST_F(Heirs, I1_WhatABrokerServesAtOneIpAddressGoesToOneHeir) {
    Endpoint dtls = address(9);
    dtls.port = 8883;
    dtls.packets = Endpoint::Packets::dtls;
    for (const LogId& member : {b1, b2, b3}) holds(member, 5, {address(9), dtls});
    EXPECT_EQ(heir_of(dtls), heir_of(address(9)));
}

TEST_F(Heirs, AnAddressThatAMemberServesStaysWithIt) {
    beacon(b2, {address(9)}, 50);
    for (const LogId& member : view.members) holds(member, 9, {address(9)});
    EXPECT_EQ(heir_of(address(9)), b2.broker);
}

// The others leave it to that one (take_over.h).
TEST_F(Heirs, I1_OfSeveralHeirsOfAnAddressTheOneThatHasItIsNamedFirst) {
    const LogId earlier = test::log_of("b9", 0);
    holds(b2, 9, {address(9)});
    holdings[b3].holds.push_back({earlier, 9});
    holdings[b3].addresses.push_back({earlier, address(9)});
    for (const LogId& has_it : {b2, b3}) {
        appointed = {{address(9), has_it}};
        EXPECT_EQ(assign(answers(), agreed_ends(answers()), membership).size(), 2U);
        EXPECT_EQ(heir_of(address(9)), has_it.broker);
    }
}

// It would not wait for the later copy that the other one passes on (simulator, faults `relapse`,
// seed 709).
TEST_F(Heirs, P3_WhoWasReplacedIsNotNamedFirst) {
    const LogId also_dead = test::log_of("b8");
    for (const auto& [known, outdated] : {std::pair{dead, also_dead}, std::pair{also_dead, dead}}) {
        holdings.clear();
        holdings[b2].holds = {{known, 9}};
        holdings[b2].addresses = {{known, address(9)}};
        holdings[b3].holds = {{outdated, 9}};
        holdings[b3].addresses = {{outdated, address(9)}};
        holdings[b3].outdated = {outdated};
        EXPECT_EQ(heir_of(address(9)), b2.broker);
    }
}

TEST_F(Heirs, AnAddressGoesToItsOwnBrokerWhenThatIsThere) {
    beacon(b2, {}, 50, {address(9)});
    for (const LogId& member : view.members) holds(member, 9, {address(9)});
    EXPECT_EQ(heir_of(address(9)), b2.broker);
}

// It has just come back, and its snapshot of the log was still on its way when the writer died.
TEST_F(Heirs, OneThatKnowsOfTheLogAndHoldsNothingOfItDoesNotInherit) {
    beacon(b3, {}, 0, {address(9)});
    holds(b2, 40, {address(9)});
    holds(b3, 0);
    EXPECT_EQ(heir_of(address(9)), b2.broker);
}

// What it takes for left lives on with others since (simulator, faults
// `stop`, acks 2, seed 250).
TEST_F(Heirs, P3_WhoWasReplacedMeanwhileKnowsOfNothingThatIsLeft) {
    holds(b1, 9);
    holds(b2, 5, {address(9)});
    holdings[b2].outdated = {dead};
    EXPECT_THAT(assign(answers(), agreed_ends(answers()), membership), IsEmpty());
    holds(b3, 9, {address(9)});
    beacon(b2, {address(9)}, 0, {address(9)});
    EXPECT_NE(heir_of(address(9)), b2.broker) << "though the address is its own";
}

TEST_F(Heirs, P2_ButWhenNobodyElseHoldsTheLogItInherits) {
    holds(b1, 0);
    holds(b2, 5, {address(9)});
    holdings[b2].outdated = {dead};
    EXPECT_EQ(heir_of(address(9)), b2.broker);
    holdings[b3].holds.push_back({test::log_of("b9", 2), 1});
    EXPECT_EQ(heir_of(address(9)), BrokerId{}) << "unless others went on: there was a later life";
}

TEST_F(Heirs, OnlyOneThatHoldsTheLogInherits) {
    holds(b1, 9, {address(9)});
    EXPECT_EQ(heir_of(address(9)), b1.broker);
}

}  // namespace
}  // namespace romano::cluster::heirs_test
