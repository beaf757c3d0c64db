// What the tests of members do over and over.
#pragma once

#include <gmock/gmock.h>

#include <chrono>
#include <initializer_list>
#include <string>
#include <vector>

#include "tests/overlay/member/brokers.h"

namespace romano::test {

inline constexpr std::chrono::seconds settling{1};

inline void start(Brokers& brokers, std::initializer_list<int> ranks) {
    for (const int rank : ranks) brokers.start(rank);
    brokers.run_for(settling);
}

inline std::vector<std::string> numbers(int first, int last) {
    std::vector<std::string> texts;
    for (int i = first; i <= last; ++i) texts.push_back(std::to_string(i));
    return texts;
}

/// A robot that is connected and subscribed.
inline Robot& subscriber(Brokers& brokers, const std::string& name, int broker, mqttsn::Qos qos,
                         const std::string& topic = "pose") {
    Robot& robot = brokers.robot(name, broker);
    robot.connect();
    robot.subscribe(topic, qos);
    brokers.run_for(std::chrono::milliseconds{200});
    return robot;
}

inline Robot& publisher(Brokers& brokers, const std::string& name, int broker) {
    Robot& robot = brokers.robot(name, broker);
    robot.connect();
    brokers.run_for(std::chrono::milliseconds{100});
    return robot;
}

/// The robot did nothing to get its session back: it never noticed anything.
inline void expect_unnoticed(const Robot& robot) {
    EXPECT_EQ(robot.count_sent(mqttsn::MsgType::connect), 1);
    EXPECT_LE(robot.count_sent(mqttsn::MsgType::subscribe), 1);
    EXPECT_LE(robot.count_sent(mqttsn::MsgType::register_), 1);
    EXPECT_EQ(robot.rejections(), 0);
}

/// A subscriber of `pose`, named "robot", talks to another broker and goes on there.
inline void goes_on_at(Brokers& brokers, Robot& robot, int broker) {
    robot.move_to(broker_address(broker));
    robot.publish("pose", "1", mqttsn::Qos::exactly_once);
    brokers.run_for(std::chrono::milliseconds{500});
    EXPECT_THAT(robot.received(), testing::ElementsAre("1"));
    EXPECT_THAT(brokers.sessions_at(broker), testing::ElementsAre("robot"));
    expect_unnoticed(robot);
}

}  // namespace romano::test
