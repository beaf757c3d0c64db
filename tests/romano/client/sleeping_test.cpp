// MQTT-SN 1.2 section 6.14: sleeping clients.

#include <gtest/gtest.h>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::sleeping_test {
namespace {

using namespace mqttsn;
using namespace std::chrono_literals;
using enum ReturnCode;

constexpr TopicId pose{5};

class Sleeping : public testing::Test {
protected:
    void SetUp() override {
        chart.connect({.client_id = "c", .keep_alive = 60s});
        chart.subscribe(topic_name("pose"), pose, qos1);
    }
    void falls_asleep() {
        chart.call([](auto& client, auto now, auto& out) { client.sleep(now, 400s, out); });
        chart.sends(Disconnect{true, 400});
        chart.gets(Disconnect{false, 0});
        chart.tells("asleep");
    }
    SequenceChart chart;
};

TEST_F(Sleeping, BeginsWithDisconnectAndItsDuration) {  // 6.14a
    falls_asleep();
    EXPECT_EQ(chart.client().state(), State::asleep);
    chart.after(299s);  // no keep-alive while asleep
}

TEST_F(Sleeping, RepeatsTheDisconnectThatIsNotAnswered) {
    chart.call([](auto& client, auto now, auto& out) { client.sleep(now, 400s, out); });
    chart.sends(Disconnect{true, 400});
    chart.after(t_retry);
    chart.sends(Disconnect{true, 400});
    chart.gets(Disconnect{false, 0});
    chart.tells("asleep");
}

TEST_F(Sleeping, CollectsItsMessagesWithinEachPeriod) {  // 6.14b
    falls_asleep();
    for (int period = 0; period < 2; ++period) {
        chart.after(299s);
        chart.is_silent();
        chart.after(1s);
        chart.sends(Pingreq{"c"});
        EXPECT_EQ(chart.client().state(), State::awake);
        chart.gets(publish_of(qos1, pose, MsgId{1}, "x"));
        chart.sends(Puback{pose, MsgId{1}, accepted});
        chart.tells("received pose x qos 1");
        chart.gets(Register{TopicId{6}, MsgId{2}, "map"});
        chart.sends(Regack{TopicId{6}, MsgId{2}, accepted});
        chart.gets(publish_of(qos0, TopicId{6}, no_msg_id, "y"));
        chart.tells("received map y qos 0");
        chart.gets(Pingresp{});
        chart.tells("asleep");
    }
}

TEST_F(Sleeping, CollectsItsMessagesAlsoWhenAsked) {
    falls_asleep();
    chart.after(10s);
    chart.call([](auto& client, auto now, auto& out) { client.wake(now, out); });
    chart.sends(Pingreq{"c"});
    chart.gets(Pingresp{});
    chart.tells("asleep");
}

TEST_F(Sleeping, AsksAgainTretryAfterTheLastMessageWithoutPingresp) {  // 6.14d
    falls_asleep();
    chart.after(300s);
    chart.sends(Pingreq{"c"});
    chart.after(9s);
    chart.gets(publish_of(qos0, pose, no_msg_id, "x"));
    chart.tells("received pose x qos 0");
    chart.after(9s);
    chart.is_silent();
    chart.after(1s);
    chart.sends(Pingreq{"c"});
    chart.gets(Pingresp{});
    chart.tells("asleep");
}

TEST_F(Sleeping, SleepsOnAfterNretryUnansweredRequests) {  // 6.14d
    falls_asleep();
    chart.after(300s);
    for (int sent = 0; sent < 1 + n_retry; ++sent) {
        chart.sends(Pingreq{"c"});
        chart.after(t_retry);
    }
    chart.tells("asleep");
    chart.after(300s);
    chart.sends(Pingreq{"c"});
}

TEST_F(Sleeping, KeepsItsOwnMessagesUntilItConnects) {  // 6.14e
    falls_asleep();
    chart.publish(topic_name("pose"), "x", qos0);
    chart.is_silent();
    chart.connect({.client_id = "c", .clean_session = false, .keep_alive = 60s});
    chart.sends(publish_of(qos0, pose, no_msg_id, "x"));
    chart.tells("published 2");
}

TEST_F(Sleeping, EndsByDisconnect) {
    falls_asleep();
    chart.call([](auto& client, auto now, auto& out) { client.disconnect(now, out); });
    chart.sends(Disconnect{false, 0});
    chart.gets(Disconnect{false, 0});
    chart.tells("disconnected");
}

}  // namespace
}  // namespace romano::client::sleeping_test
