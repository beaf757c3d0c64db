// What the broker sends once for its cell: romano/mqttsn/cell.md.
#include "romano/mqttsn/cell.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/romano/client/exchange.h"
#include "tests/romano/client/sequence_chart.h"

namespace romano::client::cell_test {
namespace {

using namespace mqttsn;
using namespace std::chrono_literals;
using enum ReturnCode;

constexpr TopicId common{5};

class Listening : public testing::Test {
protected:
    void SetUp() override {
        chart.connect();
        chart.subscribe(topic_name("common"), common, qos1);
        chart.subscribe(topic_name(cell_topic), TopicId{6}, qos0);
    }

    void hears(Qos qos, std::string_view data, MsgId msg_id = no_msg_id, unsigned steps = 0,
               std::vector<std::uint16_t> exceptions = {}, std::string_view name = "common",
               MsgId behind = no_msg_id) {
        std::vector<std::uint8_t> rest{static_cast<std::uint8_t>(exceptions.size())};
        for (const std::uint16_t number : exceptions) {
            rest.push_back(static_cast<std::uint8_t>(number >> 8U));
            rest.push_back(static_cast<std::uint8_t>(number));
        }
        if (qos == qos1) {
            rest.push_back(static_cast<std::uint8_t>(static_cast<unsigned>(behind) >> 8U));
            rest.push_back(static_cast<std::uint8_t>(behind));
        }
        rest.insert(rest.end(), name.begin(), name.end());
        rest.insert(rest.end(), data.begin(), data.end());
        hears_octets(octets_of(Publish{false, qos, false, TopicIdType::reserved,
                                       cell_sizes(steps, name), msg_id, rest}));
    }
    /// At QoS 1, in a spread of 2.55 s.
    void hears_behind(MsgId behind, std::string_view data, MsgId msg_id) {
        hears(qos1, data, msg_id, 255, {}, "common", behind);
    }
    void hears_octets(const Octets& octets) { chart.gets_octets(octets); }
    /// Of the chart's client, "c", in a spread of 2.55 s.
    static constexpr Duration own_time = cell_answer_delay(255, listener_number("c"));

    SequenceChart chart;
};

TEST_F(Listening, AtQos0IsTakenAndNotAnswered) {
    hears(qos0, "x");
    chart.tells("received common x qos 0");
    chart.after(10s);
}

TEST_F(Listening, AtQos1IsAnsweredAtItsOwnTimeInTheSpread) {
    static_assert(own_time > 20ms && own_time < 2550ms);
    hears(qos1, "x", MsgId{9}, 255);
    chart.tells("received common x qos 1");
    chart.after(own_time - 10ms);
    chart.is_silent();
    chart.after(10ms);
    chart.sends(Puback{common, MsgId{9}, accepted});
}

TEST_F(Listening, AnAnswerThatIsOwedGoesBeforeAnythingElse) {
    hears(qos1, "x", MsgId{9}, 255);
    chart.tells("received common x qos 1");
    chart.gets(publish_of(qos1, common, MsgId{10}, "y"));
    chart.sends(Puback{common, MsgId{9}, accepted});
    chart.sends(Puback{common, MsgId{10}, accepted});
    chart.tells("received common y qos 1");
    hears(qos1, "z", MsgId{11}, 255);
    chart.tells("received common z qos 1");
    hears(qos1, "u", MsgId{12}, 0);
    chart.sends(Puback{common, MsgId{11}, accepted});
    chart.tells("received common u qos 1");
    chart.after(1ms);
    chart.sends(Puback{common, MsgId{12}, accepted});
}

TEST_F(Listening, ABurstIsAnsweredOnceForAllAtTheTimeOfItsFirst) {
    hears_behind(no_msg_id, "x", MsgId{9});
    chart.tells("received common x qos 1");
    chart.after(own_time - 10ms);
    hears_behind(MsgId{9}, "y", MsgId{10});
    chart.tells("received common y qos 1");
    hears(qos0, "now");  // needs no answer, and hurries none
    chart.tells("received common now qos 0");
    chart.is_silent();
    chart.after(10ms);
    chart.sends(Puback{common, MsgId{10}, accepted});
    hears_behind(MsgId{10}, "z", MsgId{11});
    chart.tells("received common z qos 1");
    chart.is_silent();
    chart.after(own_time);
    chart.sends(Puback{common, MsgId{11}, accepted});
}

TEST_F(Listening, WhoMissedOneTakesNoneBehindItUntilThatCameByUnicast) {  // P5
    hears_behind(no_msg_id, "1", MsgId{9});
    chart.tells("received common 1 qos 1");
    hears_behind(MsgId{10}, "3", MsgId{11});  // "2" was lost
    hears_behind(MsgId{11}, "4", MsgId{12});
    chart.after(own_time);
    chart.sends(Puback{common, MsgId{9}, accepted});
    chart.gets(publish_of(qos1, common, MsgId{10}, "2"));
    chart.sends(Puback{common, MsgId{10}, accepted});
    chart.tells("received common 2 qos 1");
    hears_behind(MsgId{10}, "3", MsgId{11});
    chart.tells("received common 3 qos 1");
    chart.after(own_time);
    chart.sends(Puback{common, MsgId{11}, accepted});
}

TEST_F(Listening, ABurstDoesNotGoOnOverANewConnection) {
    hears_behind(no_msg_id, "1", MsgId{9});
    chart.tells("received common 1 qos 1");
    chart.connect({.client_id = "c", .clean_session = false, .keep_alive = {}});
    chart.subscribe(topic_name(cell_topic), TopicId{6}, qos0);
    hears_behind(MsgId{9}, "2", MsgId{10});
    chart.after(10s);
}

TEST_F(Listening, WhatIsNotForThisListenerIsPassedOver) {
    hears(qos1, "x", MsgId{9}, 0, {7, listener_number("c")});
    hears(qos0, "x", no_msg_id, 0, {}, "other");
    chart.after(10s);
    EXPECT_EQ(chart.client().dropped(), 0u);
    hears(qos0, "x", no_msg_id, 0, {7, 8});
    chart.tells("received common x qos 0");
}

TEST_F(Listening, EndsWithTheConnectionAndWithUnsubscribe) {
    chart.call([](auto& client, auto now, auto& out) {
        (void)client.unsubscribe(now, topic_name(cell_topic), out);
    });
    chart.sends(Unsubscribe{MsgId{3}, {TopicIdType::normal, cell_topic, no_topic_id}});
    hears(qos0, "x");  // on the way to the broker already
    chart.gets(Unsuback{MsgId{3}});
    chart.tells("unsubscribed 3");
    hears(qos0, "x");
    chart.call([](auto& client, auto now, auto& out) {
        (void)client.subscribe(now, topic_name(cell_topic), qos0, out);
    });
    chart.sends(subscribe_of(cell_topic, qos0, MsgId{4}));
    hears(qos0, "x");  // the broker need not know yet
    chart.gets(Suback{qos0, TopicId{6}, MsgId{4}, accepted});
    chart.tells("subscribed 4 id 6 qos 0");
    hears(qos0, "x");
    chart.tells("received common x qos 0");
    chart.connect({.client_id = "c", .clean_session = false, .keep_alive = {}});
    hears(qos0, "x");
}

TEST_F(Listening, AnyOctetsAreDroppedAndCounted) {
    const Octets good =
        octets_of(Publish{false, qos0, false, TopicIdType::reserved, cell_sizes(0, "common"),
                          no_msg_id, as_octets(std::string_view{"\0commonx", 8})});
    std::uint32_t bad = 0;
    for (std::size_t size = 0; size + 1 < good.size(); ++size) {  // an empty payload is one, too
        Octets cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
        if (size > 0) cut[0] = static_cast<std::uint8_t>(size);
        hears_octets(cut);
        ++bad;
    }
    EXPECT_EQ(chart.client().dropped(), bad);
}

}  // namespace
}  // namespace romano::client::cell_test
