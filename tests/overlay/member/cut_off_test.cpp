// A broker whose network failed, and clients that only the other side reached meanwhile.

#include "overlay/member/cut_off.h"

#include <gmock/gmock.h>

#include "tests/overlay/member/brokers.h"

namespace romano::test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using overlay::CutOff;
using testing::ElementsAre;

Endpoint client(std::uint8_t host) {
    return {.address = {10, 0, 1, host}, .port = 5000, .family = Endpoint::Family::ipv4};
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

bool fell_silent(const broker::LogId&) {
    return false;
}

TEST(CutOff, RepeatsNothingToThoseThatWereNotHeardSince) {
    CutOff cut_off;
    cut_off.on_view(view(1, {member(1), member(2), member(3)}), fell_silent);
    cut_off.on_heard(client(1));
    EXPECT_FALSE(cut_off.withholds(client(1), publish(0xC0)));
    cut_off.on_view(view(2, {member(1)}), fell_silent);
    EXPECT_TRUE(cut_off.withholds(client(1), publish(0xC0)));
    EXPECT_FALSE(cut_off.withholds(client(1), publish(0x40))) << "the first time";
    EXPECT_TRUE(cut_off.withholds(client(1), publish(0xA0))) << "QoS 1";
    EXPECT_TRUE(cut_off.withholds(client(1), std::vector<std::uint8_t>{4, 0x10, 0, 1})) << "PUBREL";
    cut_off.on_heard(client(2));
    EXPECT_FALSE(cut_off.withholds(client(2), publish(0xC0)));
    EXPECT_TRUE(cut_off.withholds(client(1), publish(0xC0)));
    cut_off.on_view(view(3, {member(1), member(2), member(3)}), fell_silent);
    EXPECT_FALSE(cut_off.withholds(client(1), publish(0xC0)));
}

TEST(CutOff, IsImpossibleForThoseWhoAreNotFewer) {
    CutOff cut_off;
    cut_off.on_view(view(1, {member(1), member(2), member(3)}), fell_silent);
    cut_off.on_view(view(2, {member(1), member(2)}), fell_silent);
    EXPECT_FALSE(cut_off.is_possible());
    cut_off.on_view(view(3, {member(1)}), fell_silent);
    EXPECT_FALSE(cut_off.is_possible()) << "one of two is as good as the other";
}

TEST(CutOff, IsImpossibleWhenTheOthersAreKnownToHaveEnded) {
    CutOff cut_off;
    cut_off.on_view(view(1, {member(1), member(2), member(3)}), fell_silent);
    cut_off.on_view(view(2, {member(1)}), [](const auto&) { return true; });
    EXPECT_FALSE(cut_off.is_possible());
}

TEST(CutOff, P3_WhatTheHeirDeliveredIsNotRepeatedWhenTheWayIsOpenAgain) {
    constexpr int robots_site = 4;
    Brokers brokers;
    for (const int rank : {1, 2, 3}) brokers.start(rank);
    brokers.run_for(1s);
    Robot& subscriber = brokers.robot("subscriber", 1, robots_site);
    subscriber.connect();
    subscriber.subscribe("pose", Qos::exactly_once);
    Robot& publisher = brokers.robot("publisher", 2);
    publisher.connect();
    brokers.run_for(200ms);

    brokers.cut(1, robots_site);
    publisher.publish("pose", "1", Qos::exactly_once);
    brokers.run_for(20ms);  // broker 1 has sent it, and has no answer
    brokers.cut(1, 2);
    brokers.cut(1, 3);
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

// The way to the clients is open again before the brokers meet: a client speaks to the broker that
// was cut off, whose copy of the session wins.
TEST(CutOff, P3_WhatTheOtherHomeDeliveredMeanwhileIsNotDeliveredAgain) {
    constexpr int robots_site = 4;
    Brokers brokers;
    for (const int rank : {1, 2, 3}) brokers.start(rank);
    brokers.run_for(1s);
    Robot& subscriber = brokers.robot("subscriber", 2, robots_site);
    subscriber.connect();
    subscriber.subscribe("pose", Qos::exactly_once);
    Robot& publisher = brokers.robot("publisher", 3);
    publisher.connect();
    brokers.run_for(200ms);

    for (const int other : {2, 3, robots_site}) brokers.cut(1, other);
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

}  // namespace
}  // namespace romano::test
