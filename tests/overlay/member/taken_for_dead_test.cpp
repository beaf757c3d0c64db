// Brokers that live and are taken for dead, mostly by a standstill, as robots see them. P1..P8 are
// the promises of the design, section 4.

#include <gmock/gmock.h>

#include "tests/overlay/member/steps.h"

namespace romano::test::taken_for_dead_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(Member, AStalledBrokerThatWasReplacedDropsWhatItHadAndGetsItBack) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    Robot& other = publisher(brokers, "other", 1);
    brokers.stall(3);
    for (const auto& text : numbers(1, 20)) {
        other.publish("pose", text, Qos::exactly_once);
        brokers.run_for(100ms);
    }
    EXPECT_NE(brokers.server_of(3), 3);
    brokers.wake(3);
    for (const auto& text : numbers(21, 40)) {
        other.publish("pose", text, Qos::exactly_once);
        brokers.run_for(100ms);
    }
    brokers.run_for(2s);
    EXPECT_EQ(robot.received(), numbers(1, 40));
    EXPECT_EQ(brokers.server_of(3), 3);
    EXPECT_THAT(brokers.sessions_at(3), ElementsAre("robot"));
    EXPECT_EQ(brokers.leader_of(1), 3);
    expect_unnoticed(robot);
}

// It may have been replaced: who goes on in its place begins the exchange under another id
// (simulator, seed 42250 as shipped).
TEST(Member, P3_WhoHasNoLeaseBeginsNoExchange) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    Robot& other = publisher(brokers, "other", 1);
    brokers.stall(3);
    other.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(88ms);  // its lease is over, and it did not stand still for a term
    brokers.wake(3);
    brokers.run_for(1ms);
    const auto waiting = brokers.member(3).broker().image("robot");
    ASSERT_EQ(waiting->deliveries.size(), 1U);
    EXPECT_EQ(waiting->deliveries[0].stage, broker::DeliveryStage::queued);
    brokers.run_for(20ms);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

/// A broker that does one thing a turn, and whose only peer is cut off for some milliseconds.
struct ManyAtOnce {
    Brokers brokers{one_event_a_turn()};
    std::vector<Robot*> robots;

    ManyAtOnce() {
        start(brokers, {1, 3});
        for (int i = 1; i <= 20; ++i) {
            robots.push_back(&publisher(brokers, "robot" + std::to_string(i), 3));
            robots.back()->publish("pose", "registered", Qos::at_most_once);
        }
        brokers.run_for(103ms);  // beacons have just come
        brokers.cut(1, 3);
    }
    static cluster::ClusterOptions one_event_a_turn() {
        cluster::ClusterOptions options;
        options.events_per_turn = 1;
        return options;
    }
    void publish() {
        for (Robot* robot : robots) robot->publish("pose", "1", Qos::at_least_once);
    }
    [[nodiscard]] std::size_t acknowledged() const {
        std::size_t sum = 0;
        for (const Robot* robot : robots) sum += robot->acknowledged();
        return sum;
    }
    void expect_acknowledged_in_pieces() {
        const std::size_t before = acknowledged();
        std::size_t last = before;
        brokers.heal();
        for (int ms = 0; ms < 200; ++ms) {
            brokers.run_for(1ms);
            EXPECT_LE(acknowledged(), last + 2) << "what is heard, and what waits";
            last = acknowledged();
        }
        EXPECT_EQ(last, before + robots.size());
        EXPECT_EQ(brokers.view_size(3), 2U) << "nobody was taken for dead";
    }
};

// Thousands said goodbye while it had no lease; served all at once they were a turn of 70 ms, and
// peers took it for dead.
TEST(Member, I8_WhatWaitedForALeaseIsServedInPieces) {
    ManyAtOnce many;
    many.brokers.run_for(80ms);  // its lease is over, and nobody is dead
    many.publish();
    many.brokers.run_for(2ms);
    EXPECT_EQ(many.brokers.member(3).facts().held_output, 0U) << "nothing was served";
    many.expect_acknowledged_in_pieces();
}

TEST(Member, I8_WhatWasNotSafeLeavesInPieces) {
    ManyAtOnce many;
    many.publish();
    many.brokers.run_for(40ms);
    EXPECT_EQ(many.brokers.member(3).facts().held_output, many.robots.size());
    many.expect_acknowledged_in_pieces();
}

// What it is sent follows its PUBACK, which waits for the peer.
TEST(Member, P3_NothingOvertakesWhatLeavesInPieces) {
    ManyAtOnce many;
    many.brokers.heal();
    Robot& robot = subscriber(many.brokers, "robot", 3, Qos::at_least_once);
    robot.publish("pose", "registered", Qos::at_least_once);
    many.brokers.run_for(103ms);
    many.brokers.cut(1, 3);
    robot.publish("pose", "0", Qos::at_least_once);
    many.brokers.run_for(2ms);
    many.publish();
    many.brokers.run_for(40ms);
    ASSERT_LT(robot.received().size(), 3U);
    many.brokers.heal();
    while (robot.received().size() < 3) many.brokers.run_for(1ms);
    many.robots.front()->publish("pose", "2", Qos::at_most_once);
    many.brokers.run_for(100ms);
    std::vector<std::string> in_order{"registered", "0"};
    in_order.resize(in_order.size() + many.robots.size(), "1");
    in_order.push_back("2");
    EXPECT_EQ(robot.received(), in_order);
}

// When the lease is back its own message is safe already, and has not left yet.
TEST(Member, P3_WhatWaitedForALeaseDoesNotOvertakeWhatWaitedForAPeer) {
    Brokers brokers;
    start(brokers, {1, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::at_least_once);
    Robot& other = publisher(brokers, "other", 3);
    robot.publish("pose", "registered", Qos::at_least_once);
    other.publish("pose", "registered", Qos::at_most_once);
    brokers.run_for(103ms);
    brokers.cut(1, 3);
    robot.publish("pose", "1", Qos::at_least_once);
    brokers.run_for(90ms);  // its lease is over
    other.publish("pose", "2", Qos::at_most_once);
    brokers.run_for(2ms);
    ASSERT_EQ(robot.received().size(), 2U);
    brokers.heal();
    brokers.run_for(100ms);
    const auto heard = robot.received();  // what is of QoS 1 perhaps twice
    EXPECT_THAT(heard, Contains("2"));
    EXPECT_TRUE(std::ranges::find(heard, "1") < std::ranges::find(heard, "2"))
        << testing::PrintToString(heard);
}

// Those who made the view without it are gone; those who came later tell it (seeds 52 and 729).
TEST(Member, P3_WhoWasAwayWhileAllOthersWereReplacedLearnsThatItWas) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    Robot& other = publisher(brokers, "other", 3);
    brokers.stall(3);
    other.publish("pose", "1", Qos::exactly_once);  // waits there, and is sent again to the heir
    brokers.run_for(settling);
    for (const int rank : {1, 2}) {
        brokers.kill(rank);
        brokers.run_for(settling);
        brokers.start(rank);
        brokers.run_for(settling);
    }
    brokers.run_for(10s);
    ASSERT_THAT(robot.received(), ElementsAre("1"));
    brokers.wake_slowly(3, 0);
    brokers.run_for(2s);
    EXPECT_EQ(brokers.member(3).facts().replacements, 1U);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

// The only other member of its view has begun a new life, and knows nothing yet; who went on for
// both is heard a moment later (simulator, seed 993428).
TEST(Member, P3_WhoWasAwayWaitsForThoseWhoCameSince) {
    Brokers brokers;
    start(brokers, {1, 3});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::exactly_once);
    Robot& other = publisher(brokers, "other", 3);
    brokers.stall(3);
    other.publish("pose", "1", Qos::exactly_once);  // waits there, and is sent again to the heir
    brokers.run_for(settling);
    brokers.start(2);
    brokers.run_for(settling);
    brokers.kill(1);
    brokers.run_for(10s);
    ASSERT_THAT(robot.received(), ElementsAre("1"));
    brokers.cut(1, 2);
    brokers.cut(2, 3);
    brokers.start(1);
    brokers.run_for(20ms);
    brokers.wake_slowly(3, 0);
    brokers.run_for(100ms);
    brokers.heal();
    brokers.run_for(2s);
    EXPECT_EQ(brokers.member(3).facts().replacements, 1U);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

// P3: those who went on without it may have answered that. Who was not answered asks again.
TEST(Member, P3_ANewcomerThatStoodStillAnswersNothingThatCameMeanwhile) {
    Brokers brokers;
    brokers.start(1);
    brokers.run_for(10ms);
    ASSERT_FALSE(brokers.member(1).cluster().is_in_view());
    Robot& robot = brokers.robot("robot", 1);
    brokers.stall(1);
    robot.connect();
    brokers.run_for(1ms);
    robot.move_to(broker_address(2));  // where it repeats that
    brokers.run_for(500ms);
    brokers.wake(1);
    brokers.run_for(2s);
    ASSERT_TRUE(brokers.member(1).cluster().is_in_view());
    EXPECT_THAT(brokers.sessions_at(1), IsEmpty());
    robot.move_to(broker_address(1));
    brokers.run_for(500ms);
    EXPECT_THAT(brokers.sessions_at(1), ElementsAre("robot"));
}

// Its patience ended in the second standstill, and nobody was there to tell it (simulator, faults
// `starve`).
TEST(Member, P3_WhoStandsStillAgainWhileItListensListensAnew) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    brokers.stall(3);
    brokers.run_for(500ms);
    ASSERT_NE(brokers.server_of(3), 3);
    brokers.cut(1, 3);
    brokers.cut(2, 3);
    brokers.wake_slowly(3, 0);  // it missed what was said
    brokers.run_for(5ms);
    brokers.stall(3);
    brokers.run_for(600ms);
    brokers.wake(3);
    brokers.run_for(200ms);
    brokers.heal();
    brokers.run_for(2s);
    EXPECT_EQ(brokers.member(3).facts().replacements, 1U);
    EXPECT_EQ(brokers.server_of(3), 3);
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(500ms);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

std::uint64_t take_overs(Brokers& brokers, std::initializer_list<int> ranks) {
    std::uint64_t all = 0;
    for (const int rank : ranks) all += brokers.member(rank).facts().take_overs;
    return all;
}

// Its standstill was shorter than the detection time, and only with the listening is it longer.
TEST(Member, NobodyIsReplacedForListening) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    brokers.stall(3);
    brokers.run_for(85ms);
    brokers.wake(3);
    brokers.run_for(1s);
    EXPECT_EQ(take_overs(brokers, {1, 2}), 0U);
    EXPECT_EQ(brokers.member(3).facts().replacements, 0U);
    EXPECT_EQ(brokers.member(3).facts().leases_lost, 1U);
    EXPECT_EQ(brokers.member(1).facts().leases_lost, 0U);
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(500ms);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

/// Stopped between its decision and its system call, it would say it when its heir has long gone
/// on.
TEST(Member, P3_WhatWasDecidedBeforeAStallIsNotSaidAfterIt) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    Robot& other = publisher(brokers, "other", 1);
    for (const auto& text : numbers(1, 5)) {
        brokers.stall_before_sending(3);
        other.publish("pose", text, Qos::exactly_once);
        brokers.run_for(1s);
        brokers.wake(3);
        brokers.run_for(3s);
    }
    EXPECT_EQ(robot.received(), numbers(1, 5));
    expect_unnoticed(robot);
}

/// Stopped between two of the messages that it reads at once, it notices that by the second one,
/// and has the first one's answers at hand.
TEST(Member, P3_WhatWasDecidedBeforeAStallIsNotSaidWhenMoreWasRead) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    Robot& other = publisher(brokers, "other", 1);
    for (const auto& text : numbers(1, 5)) {
        brokers.stall_before_reading_on(3);
        other.publish("pose", text, Qos::exactly_once);
        brokers.run_for(1s);
        brokers.wake_slowly(3, 1000);
        brokers.run_for(3s);
    }
    EXPECT_EQ(robot.received(), numbers(1, 5));
    expect_unnoticed(robot);
}

/// Its peers never heard it, so that it never learns who answered for it.
TEST(Member, P3_WhatWaitedAtANewcomerThatStoodStillIsForgotten) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    brokers.kill(3);
    brokers.cut(1, 3);
    brokers.cut(2, 3);
    brokers.start(3);
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(5ms);
    brokers.stall(3);
    brokers.heal();
    brokers.run_for(15s);  // it asks again after ten
    ASSERT_THAT(robot.received(), ElementsAre("1"));
    brokers.wake(3);
    brokers.run_for(3s);
    EXPECT_EQ(brokers.server_of(3), 3);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
    expect_unnoticed(robot);
}

TEST(Member, WhatWasNotSaidBeforeAStallIsSaidAfterItWhenNobodyTookOver) {
    Brokers brokers;
    start(brokers, {1});
    Robot& robot = subscriber(brokers, "robot", 1, Qos::at_least_once);
    Robot& other = publisher(brokers, "other", 1);
    brokers.stall_before_sending(1);
    other.publish("pose", "1", Qos::at_most_once);
    other.publish("pose", "2", Qos::at_least_once);
    brokers.run_for(1s);
    EXPECT_THAT(robot.received(), IsEmpty());
    brokers.wake(1);
    brokers.run_for(1s);  // Tretry is ten seconds
    EXPECT_THAT(robot.received(), Contains("2"));
}

TEST(Member, APauseShorterThanTheDetectionTimeChangesNothing) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::at_least_once);
    const auto before = brokers.member(1).view();
    brokers.stall(3);
    brokers.run_for(50ms);
    brokers.wake(3);
    robot.publish("pose", "1", Qos::at_least_once);
    brokers.run_for(settling);
    EXPECT_EQ(brokers.member(1).view(), before);
    EXPECT_THAT(robot.received(), ElementsAre("1"));
}

/// Of two voters neither is replaced. The robot's PUBLISH waits at the one that stands still, and
/// its repetition at the other one, whose lease is back first: it asks for the session.
TEST(Member, P3_WhatWaitsWhereItsSessionLeavesIsHeardAtTheNextHomeOnly) {
    cluster::ClusterOptions options;
    options.elector = "raft";
    options.voters = {"b1", "b2"};
    Brokers brokers(options);
    brokers.start(1);
    brokers.run_for(5ms);  // their beacons leave at different times
    start(brokers, {2});
    Robot& listener = subscriber(brokers, "listener", 1, Qos::exactly_once);
    Robot& robot = publisher(brokers, "robot", 2);
    robot.publish("pose", "0", Qos::exactly_once);
    brokers.run_for(100ms);
    brokers.stall(2);
    robot.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(100ms);
    robot.move_to(broker_address(1));
    brokers.run_for(300ms);
    brokers.wake(2);
    brokers.run_for(settling);
    EXPECT_THAT(listener.received(), ElementsAre("0", "1"));
    EXPECT_THAT(brokers.sessions_at(1), ElementsAre("listener", "robot"));
    EXPECT_EQ(robot.acknowledged(), 2U);
    expect_unnoticed(robot);
}

/// A message of QoS 1 each millisecond.
void publish_for(Brokers& brokers, Robot& robot, std::chrono::milliseconds time) {
    for (; time > 0ms; time -= 1ms) {
        robot.publish("pose", "1", Qos::at_least_once);
        brokers.run_for(1ms);
    }
}

/// Its address is its own again, and its robot's session is not: what the robot answers to its home
/// ends at the dead one's socket.
TEST(Member, P2_ABrokerThatIsStruckJustAfterItsReturnIsReplacedAsSoon) {
    for (const auto after : {0ms, 5ms, 9ms}) {
        SCOPED_TRACE(after.count());
        Brokers brokers;
        start(brokers, {1, 2, 3});
        Robot& robot = subscriber(brokers, "robot", 1, Qos::at_least_once);
        Robot& other = publisher(brokers, "other", 2);
        publish_for(brokers, other, 30ms);
        brokers.stall(1);
        publish_for(brokers, other, 170ms);
        ASSERT_NE(brokers.server_of(1), 1);
        brokers.wake(1);
        for (int i = 0; i < 1000 && brokers.server_of(1) != 1; ++i)
            publish_for(brokers, other, 1ms);
        publish_for(brokers, other, after);
        brokers.stall(1);
        const auto received = robot.received().size();
        publish_for(brokers, other, 130ms);
        EXPECT_GT(robot.received().size(), received + 5);
        expect_unnoticed(robot);
    }
}

/// It goes on just as the others leave it out, and they take it back: it forgets what robots said,
/// an answer among that.
TEST(Member, P2_WhoIsTakenBackWaitsForNoAnswerThatItForgot) {
    for (const auto away : {93ms, 94ms, 95ms, 96ms, 97ms, 98ms, 99ms}) {
        SCOPED_TRACE(away.count());
        Brokers brokers;
        start(brokers, {1, 2, 3});
        Robot& robot = subscriber(brokers, "robot", 1, Qos::at_least_once);
        Robot& other = publisher(brokers, "other", 2);
        publish_for(brokers, other, 38ms);
        brokers.stall(1);
        publish_for(brokers, other, away);
        brokers.wake(1);
        const auto received = robot.received().size();
        publish_for(brokers, other, 100ms);
        EXPECT_GT(robot.received().size(), received + 5);
        expect_unnoticed(robot);
    }
}

/// Stopped between a beat and its beacon, it sees no standstill when it goes on. Its heir's socket
/// is newer than its own, and what robots say must not end there.
TEST(Member, ABrokerThatWasReplacedForAMomentHearsItsRobotsAtOnce) {
    Brokers brokers;
    brokers.start(3);
    brokers.run_for(1ms);  // its peers beat just after its beacons come
    start(brokers, {1, 2});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::at_least_once);
    Robot& other = publisher(brokers, "other", 1);
    const auto publish_for = [&](int milliseconds) {
        for (int i = 0; i < milliseconds; ++i) {
            other.publish("pose", "1", Qos::at_most_once);
            brokers.run_for(1ms);
        }
    };
    publish_for(29);
    brokers.stall_before_sending(3);
    publish_for(95);
    ASSERT_NE(brokers.server_of(3), 3);
    brokers.wake(3);
    brokers.run_for(5ms);
    EXPECT_EQ(brokers.server_of(3), 3);
    robot.publish("pose", "2", Qos::at_least_once);
    brokers.run_for(200ms);
    EXPECT_THAT(robot.received(), Contains("2"));
    EXPECT_EQ(brokers.member(3).facts().replacements, 0U);
    expect_unnoticed(robot);
}

/// Whoever falsely took a peer for dead also took in clients at its address.
TEST(Member, P2_ASessionBegunAtAFalseHeirOutlivesTheHeal) {
    for (int delay = 0; delay <= 200; delay += 20) {
        SCOPED_TRACE(std::to_string(delay) + " ms from CONNECT to the heal");
        Brokers brokers;
        start(brokers, {1, 2, 3});
        brokers.cut(1, 3);
        brokers.cut(2, 3);
        brokers.run_for(300ms);
        ASSERT_EQ(brokers.server_of(2), 3);
        Robot& robot = brokers.robot("robot", 2, 3);
        robot.connect();
        robot.subscribe("pose", Qos::exactly_once);
        brokers.run_for(std::chrono::milliseconds{delay});
        brokers.heal();
        brokers.run_for(2s);
        EXPECT_EQ(brokers.server_of(2), 2);
        Robot& other = publisher(brokers, "other", 1);
        other.publish("pose", "1", Qos::exactly_once);
        brokers.run_for(2s);
        EXPECT_THAT(robot.received(), ElementsAre("1"));
        EXPECT_EQ(robot.rejections(), 0);
    }
}

// After SIGSTOP, SIGCONT: the oldest of what came meanwhile is read first, the rest found no room,
// and the transport takes a moment until it hears the peers again.
TEST(Member, AReplacedLeaderIsNotMisledByBeaconsFromBeforeItWasReplaced) {
    Brokers brokers;
    start(brokers, {1, 2, 3});
    Robot& robot = subscriber(brokers, "robot", 3, Qos::exactly_once);
    Robot& other = publisher(brokers, "other", 2);
    brokers.stall(3);
    for (const auto& text : numbers(1, 10)) other.publish("pose", text, Qos::exactly_once);
    brokers.run_for(2s);
    brokers.cut(1, 3);
    brokers.cut(2, 3);
    brokers.wake_slowly(3, 20);
    brokers.run_for(150ms);
    brokers.heal();
    for (const auto& text : numbers(11, 20)) other.publish("pose", text, Qos::exactly_once);
    brokers.run_for(2s);
    EXPECT_EQ(robot.received(), numbers(1, 20));
    expect_unnoticed(robot);
    EXPECT_EQ(brokers.view_size(3), 3U);
}

}  // namespace
}  // namespace romano::test::taken_for_dead_test
