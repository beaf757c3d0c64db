// While many sessions move, those come first for which somebody waits.
#include "overlay/cluster/ownership/awaited_sessions.h"

#include <gtest/gtest.h>

#include <functional>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::awaited_sessions_test {
namespace {

using namespace two_brokers;

constexpr std::size_t sessions = 600;
constexpr std::uint8_t pingreq[] = {2, 0x16};

/// Where that client is.
Endpoint place(std::size_t number) {
    Endpoint endpoint = test::address(99);
    endpoint.port = static_cast<std::uint16_t>(number + 1);
    return endpoint;
}

broker::SessionImage subscriber(std::size_t number, const std::string& filter,
                                const Endpoint& via = theirs) {
    broker::SessionImage session = image(number, via);
    session.header.address.endpoint = place(number);
    session.subscriptions.push_back({.filter = filter, .granted = mqttsn::Qos::at_least_once});
    return session;
}

std::string topic(std::size_t number) {
    return "for/" + std::to_string(number);
}

using Clients = std::vector<broker::ClientId>;

TEST(AwaitedSessions, AMessageIsWaitedForThatWasPublishedBeforeOrAfterTheSessionWasListed) {
    AwaitedSessions awaited;
    awaited.list(subscriber(1, "a"));
    awaited.on_publish("a");
    awaited.on_publish("b");
    awaited.list(subscriber(2, "b"));
    awaited.list(subscriber(3, "c"));
    EXPECT_EQ(awaited.take(10), (Clients{client(1), client(2)}));
    EXPECT_TRUE(awaited.take(10).empty());
    awaited.on_publish("c");
    EXPECT_EQ(awaited.take(10), Clients{client(3)});
    awaited.on_publish("c");
    EXPECT_TRUE(awaited.take(10).empty()) << "it has come";
}

TEST(AwaitedSessions, WhatMatchesAWildcardIsWaitedForToo) {
    AwaitedSessions awaited;
    awaited.list(subscriber(1, "a/+"));
    awaited.on_publish("a/b");
    awaited.list(subscriber(2, "#"));
    EXPECT_EQ(awaited.take(10), (Clients{client(1), client(2)}));
}

TEST(AwaitedSessions, NobodyWaitsForOneThatSleeps) {
    AwaitedSessions awaited;
    auto sleeper = subscriber(1, "a");
    sleeper.header.state = broker::SessionState::asleep;
    awaited.list(sleeper);
    awaited.on_publish("a");
    EXPECT_TRUE(awaited.take(10).empty());
}

TEST(AwaitedSessions, SoManyAtMostAreTaken) {
    AwaitedSessions awaited;
    for (std::size_t i = 1; i <= 3; ++i) awaited.on_client(client(i));
    EXPECT_EQ(awaited.take(2), (Clients{client(1), client(2)}));
    EXPECT_EQ(awaited.take(2), Clients{client(3)});
}

/// "self" is about to adopt all sessions of "peer", and has listed them.
template <typename Before>
struct HeirFrom : Before {
    /// `hear_others` is called whenever "peer" is heard.
    explicit HeirFrom(const std::function<void(HeirFrom&)>& hear_others = [](HeirFrom&) {}) {
        this->serve(ours);
        for (int i = 0; i < 10; ++i) {
            this->hear(sessions);
            hear_others(*this);
        }
        for (std::size_t first = 0; first < sessions; first += 100) {
            LogBatch batch{.log = peer, .first_seq = first + 1};
            for (std::size_t i = first; i < first + 100; ++i) {
                batch.events.push_back(
                    broker::LogEvent{broker::SessionPut{.image = subscriber(i, topic(i))}});
            }
            this->take(std::move(batch));
            while (this->core.peer_logs().at(peer).applied() < first + 100) this->tick();
        }
        for (int i = 0; i < 100 && !this->core.take_over().is_half_adopted(theirs); ++i)
            this->pass();
        this->serve(theirs);
        this->tick();
        EXPECT_EQ(this->broker.session_count(), 0U);
    }
    [[nodiscard]] bool is_home_of(std::size_t number) const {
        return this->broker.header(client(number)) != nullptr;
    }
    /// The client that is the last one but so many in its turn.
    [[nodiscard]] std::size_t last_but(std::size_t others) const {
        const auto left = this->core.peer_logs().at(peer).clients_left(theirs);
        std::size_t number = 0;
        while (client(number) != left.at(left.size() - 1 - others)) ++number;
        return number;
    }
};
using Heir = HeirFrom<InAView>;
using HeirOfAnOutdatedLog = HeirFrom<Cluster>;  // it was in no view with "peer"

// P7: a client is answered soon, however many others its broker had.
TEST(AwaitedSessions, P7_AnHeirAdoptsThoseFirstThatSpeakOrAreWrittenTo) {
    Heir heir;
    Effects acting = heir.effects();
    const std::size_t speaks = heir.last_but(0);
    const std::size_t is_written_to = heir.last_but(1);
    const std::size_t later = heir.last_but(2);
    EXPECT_TRUE(heir.waits_for_session(theirs, place(speaks)));
    heir.core.hurry(acting, theirs, place(speaks), pingreq);
    heir.broker.publish(heir.now, topic(is_written_to), {}, mqttsn::Qos::at_least_once, false,
                        heir.clients);
    heir.keep_log();
    heir.tick();
    EXPECT_TRUE(heir.is_home_of(speaks));
    EXPECT_TRUE(heir.is_home_of(is_written_to));
    EXPECT_FALSE(heir.waits_for_session(theirs, place(speaks)));
    ASSERT_FALSE(heir.is_home_of(later));
    EXPECT_TRUE(heir.waits_for_session(theirs, place(later)));
}

TEST(AwaitedSessions, P7_AlsoOfAnOutdatedLogThoseComeFirstThatAreWrittenTo) {
    HeirOfAnOutdatedLog heir;
    const std::size_t is_written_to = heir.last_but(0);
    heir.broker.publish(heir.now, topic(is_written_to), {}, mqttsn::Qos::at_least_once, false,
                        heir.clients);
    heir.keep_log();
    heir.tick();
    EXPECT_TRUE(heir.is_home_of(is_written_to));
}

// P7: what rests leaves the processor to others.
TEST(AwaitedSessions, P7_AnHeirMayRestWhileNobodyWaitsForThem) {
    Heir heir;
    EXPECT_TRUE(heir.core.may_rest());
    heir.broker.publish(heir.now, topic(heir.last_but(0)), {}, mqttsn::Qos::at_least_once, false,
                        heir.clients);
    heir.keep_log();
    EXPECT_FALSE(heir.core.may_rest());
    heir.tick();
    EXPECT_TRUE(heir.core.may_rest());
}

// I7: it would be taken for the other one.
TEST(AwaitedSessions, I7_AClientIsNotServedAsAnotherOneOfItsAddressWhileItsSessionIsToCome) {
    Heir heir;
    auto neighbour = subscriber(sessions, "a", ours);
    neighbour.header.address.endpoint = place(599);
    (void)heir.broker.adopt(heir.now, std::move(neighbour), {}, heir.clients);
    heir.keep_log();
    EXPECT_TRUE(heir.broker.serves(theirs, place(599), pingreq));
    EXPECT_TRUE(heir.waits_for_session(theirs, place(599)));
}

// P3: what the older copy would begin, the later one may have ended.
TEST(AwaitedSessions, P3_NobodyIsServedWhileALaterCopyMayComeFromAnotherLog) {
    const LogId other = test::log_of("other");
    LogBatch of_others{.log = other, .first_seq = 1};
    for (std::size_t i = 500; i < sessions; ++i) {
        of_others.events.push_back(
            broker::LogEvent{broker::SessionPut{.image = subscriber(i, topic(i))}});
    }
    HeirOfAnOutdatedLog heir{[&](HeirOfAnOutdatedLog& it) {
        it.take(Beacon{.name = "other",
                       .log = other,
                       .last_seq = of_others.events.size(),
                       .tick = it.ticks,
                       .hears = {self.broker, peer.broker},
                       .echoes = {{self, it.core.beacon(it.broker).tick}}});
        it.take(of_others);
    }};
    ASSERT_TRUE(heir.core.take_over().is_adopted_from_several(theirs));
    heir.tick();
    ASSERT_TRUE(heir.core.take_over().is_half_adopted(theirs));
    std::size_t here = 0;
    while (!heir.is_home_of(here)) ++here;
    EXPECT_TRUE(heir.waits_for_session(theirs, place(here)));
}

// P3: its client would hear what it was answered here beside what it hears there (simulator, seed
// 2511 as shipped).
TEST(AwaitedSessions, P3_OneThatSpeaksAtTheAddressThatGoesBackFollowsItsAnswers) {
    Cluster holder;
    holder.serve(ours);
    for (int i = 0; i < 5; ++i) holder.hear();
    const Endpoint inherited = test::address(3);
    holder.serve(inherited);
    (void)holder.broker.adopt(holder.now, subscriber(1, "a", inherited), {}, holder.clients);
    holder.keep_log();
    holder.take(SessionRequest{client(1), inherited});
    EXPECT_NE(holder.broker.header(client(1)), nullptr);
    holder.take(SessionRequest{client(1), theirs});
    EXPECT_EQ(holder.broker.header(client(1)), nullptr) << "it roams";
}

}  // namespace
}  // namespace romano::cluster::awaited_sessions_test
