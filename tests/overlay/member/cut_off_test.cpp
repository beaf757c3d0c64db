// A broker whose network failed, and clients that only the other side reached meanwhile.

#include "overlay/cluster/speaking/cut_off.h"

#include <gmock/gmock.h>

#include <set>
#include <string>
#include <vector>

#include "tests/overlay/member/steps.h"

namespace romano::test::cut_off_test {
namespace {

using namespace std::chrono_literals;
using cluster::CutOff;
using mqttsn::Qos;
using Address = CutOff::Address;
using testing::ElementsAre;

cluster::Way client(std::uint8_t host, int broker = 1) {
    return {broker_address(broker),
            {.address = {10, 0, 1, host}, .port = 5000, .family = Endpoint::Family::ipv4}};
}

broker::LogId member(std::uint64_t id) {
    return {broker::BrokerId{id}, 1};
}

cluster::View view(std::uint64_t count, const std::vector<broker::LogId>& members) {
    return {.number = {.term = 1, .leader = members.front().broker, .count = count},
            .members = members};
}

/// PUBLISH of MQTT-SN 1.2 section 5.4.12, without data.
std::vector<std::uint8_t> publish(std::uint8_t flags) {
    return {7, 0x0C, flags, 0, 1, 0, 1};
}

/// Of a member that is missing: it fell silent; of one that is there: it is heard.
void see(CutOff& cut_off, const cluster::View& view) {
    const auto fell_silent = [](const auto&) { return false; };
    const auto is_heard = [](const auto&) { return true; };
    cut_off.on_view(Instant{1s}, view, fell_silent, is_heard);
}

void start_three(Brokers& brokers) {
    start(brokers, {1, 2, 3});
}

constexpr int robots_site = 4;

/// It stands apart from all brokers.
Robot& subscriber_apart(Brokers& brokers, int broker) {
    Robot& robot = brokers.robot("subscriber", broker, robots_site);
    robot.connect();
    robot.subscribe("pose", Qos::exactly_once);
    return robot;
}

/// From the other brokers, not from the robots beside it.
void cut_off_the_first(Brokers& brokers) {
    for (const int other : {2, 3}) brokers.cut(1, other);
}

TEST(CutOff, RepeatsNothingToThoseThatWereNotHeardSince) {
    const Instant now{1s};
    CutOff cut_off{500ms};
    see(cut_off, view(1, {member(1), member(2), member(3)}));
    EXPECT_FALSE(cut_off.must_wait(now, client(1)));
    EXPECT_FALSE(cut_off.withholds(now, Address::own, client(1), publish(0xC0)));
    see(cut_off, view(2, {member(1)}));
    EXPECT_TRUE(cut_off.withholds(now, Address::own, client(1), publish(0xC0)));
    EXPECT_FALSE(cut_off.withholds(now, Address::own, client(1), publish(0x40)))
        << "the first time";
    EXPECT_TRUE(cut_off.withholds(now, Address::own, client(1), publish(0xA0))) << "QoS 1";
    EXPECT_TRUE(cut_off.withholds(now, Address::taken_over, client(1), publish(0x40)))
        << "its heir may have sent it";
    EXPECT_FALSE(cut_off.withholds(now, Address::taken_over, client(1), publish(0x20)));
    const std::vector<std::uint8_t> pubrel{4, 0x10, 0, 1};
    EXPECT_TRUE(cut_off.withholds(now, Address::own, client(1), pubrel));
    EXPECT_TRUE(cut_off.must_wait(now, client(2))) << "the others may be on their way";
    EXPECT_TRUE(cut_off.withholds(now, Address::own, client(2), publish(0xC0)));
    EXPECT_FALSE(cut_off.must_wait(now + 500ms, client(2)));
    EXPECT_FALSE(cut_off.withholds(now + 500ms, Address::own, client(2), publish(0xC0)));
    EXPECT_TRUE(cut_off.withholds(now + 500ms, Address::own, client(1), publish(0xC0)));
    see(cut_off, view(3, {member(1), member(2), member(3)}));
    EXPECT_FALSE(cut_off.withholds(now, Address::own, client(1), publish(0xC0)));
    EXPECT_FALSE(cut_off.must_wait(now, client(3)));
}

TEST(CutOff, WhoWasHeardInDoubtDoesNotWaitAndIsSentNothingTwiceYet) {
    const Instant now{1s};
    CutOff cut_off{500ms};
    see(cut_off, view(1, {member(1), member(2), member(3)}));
    cut_off.on_heard_in_doubt(now, client(1));
    EXPECT_FALSE(cut_off.must_wait(now, client(1)));
    see(cut_off, view(2, {member(1)}));
    EXPECT_FALSE(cut_off.must_wait(now, client(1)));
    EXPECT_TRUE(cut_off.withholds(now, Address::own, client(1), publish(0xC0)));
    EXPECT_FALSE(cut_off.withholds(now + 500ms, Address::own, client(1), publish(0xC0)));
    EXPECT_TRUE(cut_off.must_wait(now, client(2)));
}

TEST(CutOff, OfTwoClientsAtOneAddressEachIsHeardForItself) {
    const Instant now{1s};
    CutOff cut_off{500ms};
    see(cut_off, view(1, {member(1), member(2), member(3)}));
    cut_off.on_heard_in_doubt(now, client(1, 1));
    see(cut_off, view(2, {member(1)}));
    EXPECT_FALSE(cut_off.must_wait(now, client(1, 1)));
    EXPECT_TRUE(cut_off.may_be_elsewhere(client(1, 2)));
    EXPECT_TRUE(cut_off.must_wait(now, client(1, 2)));
}

TEST(CutOff, WhoWasHeardInADoubtThatCameToNothingWaitsInTheNextOne) {
    CutOff cut_off{500ms};
    see(cut_off, view(1, {member(1), member(2), member(3)}));
    cut_off.on_heard_in_doubt(Instant{200ms}, client(1));
    cut_off.on_heard_in_doubt(Instant{700ms}, client(2));
    see(cut_off, view(2, {member(1)}));  // at one second
    EXPECT_TRUE(cut_off.must_wait(Instant{1s}, client(1)));
    EXPECT_FALSE(cut_off.must_wait(Instant{1s}, client(2)));

    see(cut_off, view(3, {member(1), member(2), member(3)}));
    see(cut_off, view(4, {member(1)}));
    EXPECT_TRUE(cut_off.must_wait(Instant{1s}, client(2)));
}

TEST(CutOff, IsImpossibleForThoseWhoAreNotFewer) {
    CutOff cut_off{500ms};
    see(cut_off, view(1, {member(1), member(2), member(3)}));
    see(cut_off, view(2, {member(1), member(2)}));
    EXPECT_FALSE(cut_off.is_possible());
    see(cut_off, view(3, {member(1)}));
    EXPECT_FALSE(cut_off.is_possible()) << "one of two is as good as the other";
}

TEST(CutOff, IsImpossibleWhenTheOthersAreKnownToHaveEnded) {
    CutOff cut_off{500ms};
    see(cut_off, view(1, {member(1), member(2), member(3)}));
    const auto yes = [](const auto&) { return true; };
    cut_off.on_view(Instant{1s}, view(2, {member(1)}), yes, yes);
    EXPECT_FALSE(cut_off.is_possible());
}

TEST(CutOff, LastsUntilAllOfTheViewThatTakesItBackAreHeard) {
    CutOff cut_off{500ms};
    see(cut_off, view(1, {member(1), member(2), member(3)}));
    see(cut_off, view(2, {member(1)}));
    const auto fell_silent = [](const auto& m) { return m == member(1); };  // but this one
    std::set<broker::LogId> heard{member(2)};
    const auto is_heard = [&](const auto& m) { return heard.contains(m); };
    const auto together = view(3, {member(1), member(2), member(3)});
    EXPECT_FALSE(cut_off.on_view(Instant{2s}, together, fell_silent, is_heard));
    EXPECT_TRUE(cut_off.withholds(Instant{2s}, Address::own, client(1), publish(0x40)))
        << "3 may have sent it";
    EXPECT_TRUE(cut_off.must_wait(Instant{2s}, client(1)));
    heard.insert(member(3));
    EXPECT_TRUE(cut_off.on_view(Instant{2s}, together, fell_silent, is_heard));
    EXPECT_FALSE(cut_off.withholds(Instant{2s}, Address::own, client(1), publish(0x40)));
    EXPECT_FALSE(cut_off.must_wait(Instant{2s}, client(1)));
}

TEST(CutOff, WhoIsNewLetsClientsWaitUntilAllOfItsFirstViewAreHeard) {
    const Instant now{1s};
    const auto fell_silent = [](const auto&) { return false; };
    std::set<broker::LogId> heard{member(1), member(2)};
    const auto is_heard = [&](const broker::LogId& id) { return heard.contains(id); };
    const cluster::View first = view(1, {member(1), member(2), member(3)});
    CutOff cut_off{500ms};
    cut_off.on_view(now, first, fell_silent, is_heard);
    EXPECT_TRUE(cut_off.must_wait(now, client(1)));
    heard.insert(member(3));
    EXPECT_TRUE(cut_off.on_view(now, first, fell_silent, is_heard)) << "it is over now";
    EXPECT_FALSE(cut_off.must_wait(now, client(1)));

    heard.erase(member(3));
    const cluster::View second = view(2, {member(1), member(2), member(3), member(4)});
    cut_off.on_view(now, second, fell_silent, is_heard);
    EXPECT_FALSE(cut_off.must_wait(now, client(1))) << "it is new no more";
}

TEST(CutOff, IsOverAfterAMomentThoughOneOfTheViewIsNotHeard) {
    CutOff cut_off{500ms};
    see(cut_off, view(1, {member(1), member(2), member(3)}));
    see(cut_off, view(2, {member(1)}));
    const auto no = [](const auto&) { return false; };
    const auto together = view(3, {member(1), member(2), member(3)});
    EXPECT_FALSE(cut_off.on_view(Instant{2s}, together, no, no));
    EXPECT_FALSE(cut_off.on_view(Instant{2s} + 499ms, together, no, no));
    EXPECT_TRUE(cut_off.on_view(Instant{2s} + 500ms, together, no, no));
}

TEST(CutOff, P3_WhatTheHeirDeliveredIsNotRepeatedWhenTheWayIsOpenAgain) {
    Brokers brokers;
    start_three(brokers);
    Robot& subscriber = subscriber_apart(brokers, 1);
    Robot& publisher = brokers.robot("publisher", 2);
    publisher.connect();
    brokers.run_for(200ms);

    brokers.cut(1, robots_site);
    publisher.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(20ms);  // broker 1 has sent it, and has no answer
    cut_off_the_first(brokers);
    brokers.run_for(1s);
    EXPECT_THAT(subscriber.received(), ElementsAre("1")) << "from the heir";
    brokers.heal(1, robots_site);  // the brokers have not found each other yet
    brokers.run_for(2s);
    EXPECT_THAT(subscriber.received(), ElementsAre("1"));

    brokers.heal();
    brokers.run_for(1s);
    publisher.publish("pose", "2", Qos::exactly_once);
    brokers.run_for(1s);
    EXPECT_THAT(subscriber.received(), ElementsAre("1", "2"));
}

// The broker that was cut off has the message, and not the word of the other home that it began.
TEST(CutOff, P3_WhatTheOtherHomeBeganAtTheCutIsNotSentForTheFirstTimeToo) {
    Brokers brokers;
    start_three(brokers);
    Robot& listener = subscriber_apart(brokers, 2);
    Robot& talker = publisher(brokers, "talker", 3);

    brokers.cut(1, 2);
    talker.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(10ms);
    ASSERT_THAT(listener.received(), ElementsAre("1"));
    brokers.cut(1, 3);
    brokers.run_for(1s);
    EXPECT_THAT(listener.received(), ElementsAre("1"));

    brokers.heal();
    brokers.run_for(1s);
    talker.publish("pose", "2", Qos::exactly_once);
    brokers.run_for(1s);
    EXPECT_THAT(listener.received(), ElementsAre("1", "2"));
}

// The way to the clients is open again before the brokers meet: a client speaks to the broker that
// was cut off, whose copy of the session wins.
TEST(CutOff, P3_WhatTheOtherHomeDeliveredMeanwhileIsNotDeliveredAgain) {
    Brokers brokers;
    start_three(brokers);
    Robot& subscriber = subscriber_apart(brokers, 2);
    Robot& publisher = brokers.robot("publisher", 3);
    publisher.connect();
    brokers.run_for(200ms);

    cut_off_the_first(brokers);
    brokers.cut(1, robots_site);
    brokers.run_for(300ms);
    for (const char* text : {"1", "2", "3"}) publisher.publish("pose", text, Qos::exactly_once);
    brokers.run_for(1s);
    EXPECT_THAT(subscriber.received(), ElementsAre("1", "2", "3"));
    brokers.heal(1, robots_site);
    subscriber.publish("hello", "x", Qos::at_least_once);
    brokers.run_for(50ms);
    brokers.heal();
    brokers.run_for(2s);
    publisher.publish("pose", "4", Qos::exactly_once);
    brokers.run_for(1s);
    EXPECT_THAT(subscriber.received(), ElementsAre("1", "2", "3", "4"));
}

// The same, and the client is in the middle of what the heir sent it. The brokers meet a moment
// after the way to the clients is open: what the client says waits for that.
TEST(CutOff, P3_WhatAClientSaysToTheBrokerThatWasCutOffWaitsForTheOthers) {
    Brokers brokers;
    start_three(brokers);
    Robot& subscriber = subscriber_apart(brokers, 2);
    Robot& publisher = brokers.robot("publisher", 1, robots_site);
    publisher.connect();
    brokers.run_for(200ms);

    cut_off_the_first(brokers);
    brokers.cut(1, robots_site);
    brokers.run_for(300ms);
    for (const char* text : {"1", "2", "3"}) publisher.publish("pose", text, Qos::exactly_once);
    brokers.run_for(500ms);
    ASSERT_THAT(subscriber.received(), ElementsAre("1", "2", "3")) << "all by the heir";
    brokers.heal(1, robots_site);
    for (const int other : {2, 3}) brokers.cut(other, robots_site);  // so that it is the one heard
    publisher.publish("pose", "4", Qos::exactly_once);
    brokers.run_for(300ms);
    EXPECT_EQ(publisher.acknowledged(), 3U);
    brokers.heal();
    brokers.run_for(2s);
    EXPECT_EQ(publisher.acknowledged(), 4U);
    EXPECT_THAT(subscriber.received(), ElementsAre("1", "2", "3", "4"));
}

// What waits at a survivor is said again to the broker that came back, and must not count twice.
TEST(CutOff, P3_WhatWaitedIsDroppedWhenItsAddressGoesBack) {
    Brokers brokers;
    for (const int rank : {1, 2, 3, 4, 5}) brokers.start(rank);
    brokers.run_for(1s);
    Robot& subscriber = brokers.robot("subscriber", 1);
    subscriber.connect();
    subscriber.subscribe("pose", Qos::exactly_once);
    Robot& publisher = brokers.robot("publisher", 1);
    publisher.connect();
    publisher.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(200ms);
    for (const int rank : {1, 2, 4, 5}) brokers.kill(rank);
    brokers.run_for(400ms);
    ASSERT_EQ(brokers.server_of(1), 3);
    publisher.publish("pose", "2", Qos::exactly_once);
    brokers.run_for(100ms);
    ASSERT_EQ(publisher.acknowledged(), 1U) << "the second one waits";
    brokers.start(1);
    brokers.run_for(3s);
    EXPECT_EQ(publisher.acknowledged(), 2U);
    EXPECT_THAT(subscriber.received(), ElementsAre("1", "2"));
}

// P3: the others would go on from a log in which that is not.
TEST(CutOff, WhoMayBeDeafSaysNothingUntilItKnows) {
    Brokers brokers;
    start_three(brokers);
    Robot& robot = publisher(brokers, "robot", 1);
    cut_off_the_first(brokers);
    brokers.run_for(150ms);
    robot.publish("pose", "1", Qos::at_least_once);
    brokers.run_for(100ms);
    EXPECT_EQ(robot.acknowledged(), 0U);
    EXPECT_EQ(brokers.server_of(2), 2) << "nor does it go on for the others";
}

// P5, also at QoS 0: the first datagram after the wait passed all that had waited.
TEST(CutOff, WhatComesIsServedAfterWhatWaits) {
    Brokers brokers;
    start_three(brokers);
    Robot& listener = subscriber(brokers, "listener", 1, Qos::at_most_once);
    Robot& talker = publisher(brokers, "talker", 1);
    talker.publish("pose", "0", Qos::exactly_once);
    brokers.run_for(200ms);
    cut_off_the_first(brokers);
    brokers.run_for(400ms);
    std::vector<std::string> sent{"0"};
    for (int i = 1; i < 80; ++i) {
        sent.push_back(std::to_string(i));
        talker.publish("pose", sent.back(), Qos::at_most_once);
        brokers.run_for(10ms);
    }
    brokers.run_for(100ms);
    EXPECT_EQ(listener.received(), sent);
}

// Two of three fall silent. A client of the third one that goes on speaking waits for the doubt.
TEST(CutOff, WhoGoesOnSpeakingIsServedAsSoonAsTheDoubtIsOver) {
    Brokers brokers;
    start_three(brokers);
    Robot& listener = subscriber(brokers, "listener", 1, Qos::at_most_once);
    Robot& talker = publisher(brokers, "talker", 1);
    talker.publish("pose", "0", Qos::exactly_once);
    brokers.run_for(200ms);
    cut_off_the_first(brokers);
    std::vector<std::string> sent{"0"};
    for (int i = 1; i < 40; ++i) {
        sent.push_back(std::to_string(i));
        talker.publish("pose", sent.back(), Qos::at_most_once);
        brokers.run_for(10ms);
    }
    EXPECT_EQ(listener.received(), sent);
}

TEST(CutOff, ClientsOfAPartThatIsCutOffAreServedAfterAMoment) {
    Brokers brokers;
    start_three(brokers);
    Robot& robot = publisher(brokers, "robot", 1);
    cut_off_the_first(brokers);
    brokers.run_for(300ms);
    robot.publish("pose", "1", Qos::at_least_once);
    brokers.run_for(2s);
    EXPECT_EQ(robot.acknowledged(), 1U);
    robot.publish("pose", "2", Qos::at_least_once);
    brokers.run_for(100ms);
    EXPECT_EQ(robot.acknowledged(), 2U) << "once is enough";
}

}  // namespace
}  // namespace romano::test::cut_off_test
