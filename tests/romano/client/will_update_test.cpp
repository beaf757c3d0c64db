// MQTT-SN 1.2 section 6.4: the will changes while connected.

#include <gtest/gtest.h>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::will_update_test {
namespace {

using namespace mqttsn;
using enum ReturnCode;

class WillUpdate : public testing::Test {
protected:
    void SetUp() override { chart.connect(); }
    void updates_topic(std::string_view topic) {
        chart.call([&](auto& client, auto now, auto& out) {
            ASSERT_TRUE(client.update_will_topic(now, topic, {qos1, true}, out));
        });
    }
    SequenceChart chart;
};

TEST_F(WillUpdate, OfTheTopicIsAnswered) {
    updates_topic("wills/c");
    chart.sends(Willtopicupd{qos1, true, "wills/c"});
    chart.after(t_retry);
    chart.sends(Willtopicupd{qos1, true, "wills/c"});
    chart.gets(Willtopicresp{accepted});
    chart.tells("will updated 1");
}

TEST_F(WillUpdate, OfAnEmptyTopicDeletesTheWill) {
    updates_topic("");
    chart.sends(Willtopicupd{qos0, false, ""});
    chart.gets(Willtopicresp{accepted});
    chart.tells("will updated 1");
}

TEST_F(WillUpdate, OfTheMessageIsAnswered) {
    chart.call([](auto& client, auto now, auto& out) {
        ASSERT_TRUE(client.update_will_message(now, as_octets("bye"), out));
    });
    chart.sends(Willmsgupd{as_octets("bye")});
    chart.gets(Willtopicresp{accepted});  // of another request
    chart.gets(Willmsgresp{accepted});
    chart.tells("will updated 1");
}

TEST_F(WillUpdate, RefusedFails) {
    updates_topic("wills/#");
    chart.sends(Willtopicupd{qos1, true, "wills/#"});
    chart.gets(Willtopicresp{not_supported});
    chart.tells("failed 1 code 3");
}

}  // namespace
}  // namespace romano::client::will_update_test
