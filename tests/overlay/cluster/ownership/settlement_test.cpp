// Two brokers are home to one client, each with the mirror of the other one's log.
#include "overlay/cluster/ownership/settlement.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "romano/base/random.h"
#include "romano/mqttsn/codec.h"
#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::settlement_test {
namespace {

using namespace two_brokers;
using namespace std::chrono_literals;

const Endpoint robots = test::address(99);
constexpr std::size_t per_turn = 4;

struct Home {
    Home(const LogId& own, const LogId& theirs, const Endpoint& at)
        : id{own}, via{at}, other{logs.try_emplace(theirs, theirs, 100).first->second} {
        (void)membership.on_beacon(Instant{10s},
                                   Beacon{.log = theirs, .tick = 1, .hears = {own.broker}});
    }

    LogId id;
    Endpoint via;
    broker::BrokerCore broker{test::writer_of(id), 1};
    broker::Actions clients;
    Outbox peers;
    std::vector<LocalAction> local;
    std::vector<broker::LogEvent> log;
    PeerLogs logs;
    PeerLog& other;
    Membership membership{ClusterOptions{}, id.broker, 1};
    HandBack hand_back{id.broker, per_turn};
    Departures departures{per_turn};
    Settlement settlement{id.broker, per_turn};

    [[nodiscard]] bool has_given_way() const { return !departures.all().empty(); }
    [[nodiscard]] std::ptrdiff_t ranks_written() {
        keep_log();
        return std::ranges::count_if(log, [](const auto& event) {
            return std::holds_alternative<broker::SessionChanged>(event);
        });
    }
    void keep_log() {
        for (const broker::Action& action : clients.list()) {
            const auto* append = std::get_if<broker::Append>(&action);
            if (append != nullptr) log.push_back(*append->event);
        }
        clients.clear();
    }
};

struct TwoHomes {
    Instant now{10s};
    Home one{self, peer, ours};
    Home two{peer, self, theirs};
    mqttsn::MsgId last_publish{};

    TwoHomes() = default;
    TwoHomes(std::uint64_t epoch_of_one, std::uint64_t epoch_of_two) {
        adopt(one, 0, epoch_of_one);
        adopt(two, 0, epoch_of_two);
        read_all();
    }

    [[nodiscard]] Effects effects(Home& home) const {
        return {now, home.broker, home.clients, home.peers, home.local, test::times};
    }
    void adopt(Home& home, std::size_t number, std::uint64_t epoch) {
        broker::SessionImage robot = image(number, home.via);
        robot.header.epoch = epoch;
        robot.header.address.endpoint = robots;
        robot.header.address.endpoint.port = static_cast<std::uint16_t>(1000 + number);
        (void)home.broker.adopt(now, std::move(robot), {}, home.clients);
        home.settlement.on_own_session(client(number), home.logs);
    }
    void hear(Home& home) {
        last_publish =
            mqttsn::MsgId{static_cast<std::uint16_t>(static_cast<std::uint16_t>(last_publish) + 1)};
        std::vector<std::uint8_t> datagram(64);
        datagram.resize(mqttsn::encode(mqttsn::Publish{false,
                                                       mqttsn::Qos::exactly_once,
                                                       false,
                                                       mqttsn::TopicIdType::short_name,
                                                       mqttsn::TopicId{0x6162},
                                                       last_publish,
                                                       {}},
                                       datagram));
        Endpoint from = robots;
        from.port = 1000;
        home.broker.on_datagram(now, home.via, from, datagram, home.clients);
    }
    void read(Home& reader, Home& writer, std::size_t most) const {
        writer.keep_log();
        for (; most > 0 && reader.other.applied() < writer.log.size(); --most) {
            const broker::LogEvent& event = writer.log[reader.other.applied()];
            reader.other.offer(reader.other.applied() + 1, {event});
            reader.other.apply();
            if (const auto* put = std::get_if<broker::SessionPut>(&event)) {
                reader.settlement.on_peer_session(effects(reader), writer.id,
                                                  put->image.header.client_id);
            } else if (const auto* changed = std::get_if<broker::SessionChanged>(&event)) {
                reader.settlement.on_peer_session(effects(reader), writer.id,
                                                  changed->header.client_id);
            }
        }
    }
    void read_all() {
        read(one, two, 1'000);
        read(two, one, 1'000);
    }
    void look(Home& home) const {
        Effects acting = effects(home);
        home.settlement.carry_on(acting, home.logs, home.membership, home.hand_back,
                                 home.departures);
    }
    void look() {
        now += test::times.conflicts_looked_at_every();
        look(one);
        look(two);
    }
};

TEST(Settlement, P4_TheCopyThatIsOutrankedMovesToTheOther) {
    TwoHomes homes(1, 2);
    homes.look();
    ASSERT_TRUE(homes.one.has_given_way());
    EXPECT_FALSE(homes.two.has_given_way());
    const MovedSession& moved = homes.one.departures.all().at(client(0)).session;
    EXPECT_EQ(moved.to, peer);
    EXPECT_EQ(moved.image.header.epoch, 1U) << "the ranks decide";
}

TEST(Settlement, P4_OfTwoEqualCopiesOneStays) {
    TwoHomes homes(1, 1);
    homes.look();
    EXPECT_EQ(homes.one.has_given_way(), peer.broker > self.broker);
    EXPECT_EQ(homes.two.has_given_way(), peer.broker < self.broker);
}

TEST(Settlement, I7_WhoBecomesHomeBesideAHigherCopyGivesWayInThatTurn) {
    TwoHomes homes;
    homes.adopt(homes.two, 0, 2);
    homes.read_all();
    homes.adopt(homes.one, 0, 1);
    homes.look(homes.one);
    EXPECT_TRUE(homes.one.has_given_way()) << "nothing more is to come from the other one";
}

// Its home would stay, and so would the other one, to which the mirror's copy is the higher.
TEST(Settlement, I7_AMirrorKnowsOfNoLaterWordThanItsHome) {
    TwoHomes homes;
    homes.adopt(homes.one, 0, 1);
    homes.now += 5ms;
    homes.hear(homes.one);
    homes.read_all();
    EXPECT_LE(homes.two.other.mirror().header(client(0))->last_heard,
              homes.one.broker.header(client(0))->last_heard);
}

// A client that is heard writes no event of that, and the other home would never give way.
TEST(Settlement, P4_WhoStaysWritesThatItsClientWasHeard) {
    TwoHomes homes;
    for (Home* home : {&homes.one, &homes.two}) {
        homes.adopt(*home, 0, 1);
        homes.hear(*home);
        homes.now += 1s;
    }
    homes.read_all();
    homes.look();
    ASSERT_TRUE(homes.one.has_given_way()) << "the other one's client was heard later";

    TwoHomes quiet(1, 2);
    quiet.look(quiet.two);
    EXPECT_EQ(quiet.two.ranks_written(), 0) << "all is in the log already";
}

/// One home's client says something that stands in no log, so that both think that they stay.
TEST(Settlement, P4_ARankIsWrittenOnceUntilItGrows) {
    TwoHomes homes(3, 3);
    Home& higher = peer.broker > self.broker ? homes.two : homes.one;
    Home& lower = peer.broker > self.broker ? homes.one : homes.two;
    std::vector<std::uint8_t> ping(8);
    ping.resize(mqttsn::encode(mqttsn::Pingreq{}, ping));
    Endpoint from = robots;
    from.port = 1000;
    const auto say = [&] {
        homes.now += 5ms;
        lower.broker.on_datagram(homes.now, lower.via, from, ping, lower.clients);
    };
    say();  // the first word at a new home stands in its log
    EXPECT_EQ(lower.ranks_written(), 1);
    say();
    for (int looks = 0; looks < 3; ++looks) {
        homes.now += test::times.conflicts_looked_at_every();
        homes.look(lower);
    }
    EXPECT_EQ(lower.ranks_written(), 2);
    say();
    homes.now += test::times.conflicts_looked_at_every();
    homes.look(lower);
    EXPECT_EQ(lower.ranks_written(), 3);
    homes.read_all();
    homes.now += test::times.conflicts_looked_at_every();
    homes.look(higher);
    EXPECT_TRUE(higher.has_given_way());
    EXPECT_EQ(higher.other.mirror().header(client(0))->last_heard,
              lower.broker.header(client(0))->last_heard);
}

// Whatever is heard, read and looked at, and in which order.
TEST(Settlement, I7_P4_NeverDoBothGiveWayAndInTheEndOneDoes) {
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Random random{seed};
        TwoHomes homes;
        homes.adopt(homes.one, 0, 1 + random.below(2));
        const std::uint32_t second = random.below(20);
        for (std::uint32_t steps = 0; steps < 60; ++steps) {
            if (steps == second) homes.adopt(homes.two, 0, 1 + random.below(2));
            const bool is_one = random.below(2) == 0;
            Home& home = is_one ? homes.one : homes.two;
            if (random.below(2) == 0) homes.now += 1ms;
            switch (random.below(4)) {
                case 0:
                    if (!home.has_given_way()) homes.hear(home);
                    break;
                case 1:
                    homes.read(home, is_one ? homes.two : homes.one, 1 + random.below(3));
                    break;
                default:
                    homes.look(home);
            }
            ASSERT_FALSE(homes.one.has_given_way() && homes.two.has_given_way());
        }
        for (int looks = 0; looks < 3; ++looks) {
            homes.read_all();
            homes.look();
            ASSERT_FALSE(homes.one.has_given_way() && homes.two.has_given_way());
        }
        EXPECT_TRUE(homes.one.has_given_way() || homes.two.has_given_way());
    }
}

TEST(Settlement, I8_ManyAreSettledInPieces) {
    TwoHomes homes;
    for (std::size_t number = 0; number < 10; ++number) {
        homes.adopt(homes.one, number, 1);
        homes.adopt(homes.two, number, 2);
    }
    homes.read_all();
    for (const std::size_t moved : {4U, 8U, 10U}) {
        homes.look(homes.one);
        EXPECT_EQ(homes.one.departures.all().size(), moved);
        EXPECT_EQ(homes.one.settlement.is_half_done(), moved == 8U);
    }
}

TEST(Settlement, I7_TheLowerCopyGivesWayInTheTurnThatReadsOfTheHigherOne) {
    TwoHomes homes;
    homes.look();
    homes.adopt(homes.one, 0, 1);
    homes.adopt(homes.two, 0, 2);
    homes.look(homes.one);
    EXPECT_FALSE(homes.one.has_given_way());
    homes.read_all();
    EXPECT_TRUE(homes.one.settlement.is_half_done());
    homes.look(homes.one);
    EXPECT_TRUE(homes.one.has_given_way());
}

// Nobody said so of these as they came: the brokers were parted.
TEST(Settlement, I8_AfterAViewAllClientsAreComparedInPieces) {
    TwoHomes homes;
    Home& home = homes.one;
    constexpr std::size_t last = Settlement::compared_per_turn;
    for (std::size_t number = 0; number <= last; ++number) {
        (void)home.broker.adopt(homes.now, image(number, home.via), {}, home.clients);
    }
    for (const std::size_t number : {std::size_t{0}, last}) {
        broker::SessionPut theirs{image(number, homes.two.via)};
        theirs.image.header.epoch = 9;
        home.other.offer(home.other.applied() + 1, {broker::LogEvent{theirs}});
        home.other.apply();
    }
    home.settlement.compare();
    for (const std::size_t moved : {1U, 2U}) {
        home.settlement.compare_some(home.broker, home.logs, {.members = {self, peer}});
        homes.look();
        EXPECT_EQ(home.departures.all().size(), moved);
        EXPECT_EQ(home.settlement.is_half_done(), moved == 1U);
    }
}

// Its image there is of no use here, and the other way round.
TEST(Settlement, OfCopiesWithOtherTopicIdsTheOneHeardLastStays) {
    TwoHomes homes;
    homes.adopt(homes.one, 0, 1);
    homes.adopt(homes.two, 0, 7);
    homes.one.other.set_foreign(true);
    homes.two.other.set_foreign(true);
    homes.hear(homes.two);
    homes.now += 1s;
    homes.hear(homes.one);
    homes.read_all();
    homes.look();
    EXPECT_NE(homes.one.broker.header(client(0)), nullptr);
    EXPECT_EQ(homes.two.broker.header(client(0)), nullptr);
    EXPECT_FALSE(homes.two.has_given_way()) << "there is nothing to move";
}

// Its broker has begun anew: it adopts nothing that is moved to that log.
TEST(Settlement, P4_NothingIsMovedToAnEarlierLife) {
    TwoHomes homes(1, 2);
    (void)homes.one.membership.on_beacon(
        homes.now, Beacon{.log = test::log_of("peer", 2), .tick = 1, .hears = {self.broker}});
    homes.look();
    EXPECT_FALSE(homes.one.has_given_way());
}

// Until it hears us again two homes of one view would speak to the client.
TEST(Settlement, I7_AHomeThatDoesNotHearUsIsGivenWayToAsWell) {
    TwoHomes homes(1, 2);
    Membership& membership = homes.one.membership;
    for (std::uint64_t tick = 2; tick < 30; ++tick) {
        homes.now += 10ms;
        (void)membership.on_beacon(homes.now, Beacon{.log = peer, .tick = tick});
        membership.on_tick(homes.now);
    }
    ASSERT_FALSE(membership.is_alive(peer));
    ASSERT_TRUE(membership.is_heard(peer));
    homes.look();
    EXPECT_TRUE(homes.one.has_given_way());
}

// Its log says so before the third one's does.
TEST(Settlement, I7_ACopyOnItsWayToAThirdHomeIsGivenWayToThere) {
    TwoHomes homes(1, 2);
    const LogId third = test::log_of("third");
    (void)homes.one.membership.on_beacon(homes.now, Beacon{.log = third, .tick = 1});
    Effects acting = homes.effects(homes.two);
    homes.two.departures.move(acting, client(0), third, 1, homes.two.logs);
    homes.read_all();
    homes.look(homes.one);
    ASSERT_TRUE(homes.one.has_given_way());
    EXPECT_EQ(homes.one.departures.all().at(client(0)).session.to, third);
}

// What comes is not confirmed here, however it was at its former home.
TEST(Settlement, I7_WhatComesGoesOnToAHigherCopyAndToNoLowerOne) {
    TwoHomes homes(1, 2);
    const auto goes_on_to = [&](std::uint64_t epoch, bool provisional) {
        broker::SessionHeader comes = *homes.two.broker.header(client(0));
        comes.epoch = epoch;
        comes.provisional = provisional;
        return homes.one.settlement.home_of_higher(comes, homes.one.logs, homes.one.membership);
    };
    EXPECT_EQ(goes_on_to(1, true), peer);
    EXPECT_EQ(goes_on_to(3, true), std::nullopt);
    EXPECT_EQ(goes_on_to(2, false), goes_on_to(2, true));
    homes.one.other.set_foreign(true);
    EXPECT_EQ(goes_on_to(1, true), std::nullopt) << "that one could not go on from it";
    homes.one.other.set_foreign(false);
    homes.one.other.freeze();
    EXPECT_EQ(goes_on_to(1, true), std::nullopt) << "nobody speaks there";
}

// What comes here is the copy of which its log tells.
TEST(Settlement, I7_WhatComesDoesNotGoBackToItsFormerHome) {
    TwoHomes homes(1, 2);
    const broker::SessionHeader comes = *homes.two.broker.header(client(0));
    Effects acting = homes.effects(homes.two);
    homes.two.departures.move(acting, client(0), self, 0, homes.two.logs);
    homes.read_all();
    EXPECT_EQ(homes.one.settlement.home_of_higher(comes, homes.one.logs, homes.one.membership),
              std::nullopt);
}

// Those that stay take no part of what a turn may give away.
TEST(Settlement, I7_WhoStaysDelaysNobodyWhoGivesWay) {
    TwoHomes homes;
    for (std::size_t number = 0; number < 2 * per_turn; ++number) {
        homes.adopt(homes.one, number, 2);
        homes.adopt(homes.two, number, 1);
    }
    homes.adopt(homes.one, 2 * per_turn, 1);
    homes.adopt(homes.two, 2 * per_turn, 2);
    homes.read_all();
    homes.look(homes.one);
    EXPECT_TRUE(homes.one.has_given_way());
}

// As the cluster core has it: by a message, and not by a tick.
TEST(SettlementOfOneTurn, I7_ACopyWhoseRankHasRisenIsGivenWayToAtOnce) {
    Cluster cluster;
    cluster.serve(ours);
    cluster.hear(2);
    broker::SessionImage copy = image(0, ours);
    copy.header.epoch = 2;
    (void)cluster.broker.adopt(cluster.now, copy, {}, cluster.clients);
    cluster.keep_log();
    copy.header.via = theirs;
    copy.header.epoch = 1;
    cluster.take(LogBatch{.log = peer, .first_seq = 1, .events = {broker::SessionPut{copy}}});
    EXPECT_NE(cluster.broker.header(client(0)), nullptr);
    copy.header.epoch = 3;
    cluster.take(
        LogBatch{.log = peer, .first_seq = 2, .events = {broker::SessionChanged{copy.header}}});
    EXPECT_EQ(cluster.broker.header(client(0)), nullptr);
}

}  // namespace
}  // namespace romano::cluster::settlement_test
