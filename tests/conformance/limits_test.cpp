// Sections 5.3.10, 6.2c, 6.5b, 6.6b, 6.9e: a full table is answered, and what is there goes on.

#include <chrono>
#include <thread>

#include "tests/conformance/suite.h"

namespace romano::conformance::limits_test {
namespace {

CONFORMANCE_SUITE(S5_3_10_Congestion, NarrowSuite);

TEST_P(S5_3_10_Congestion, s6_2c_AConnectBeyondAllSessionsIsRefused) {
    std::vector<Client*> all;
    for (std::size_t n = 0; n < Narrow::sessions; ++n) all.push_back(&connected());
    Client& another = client();
    another.says(connect(another.id));
    another.hears(connack(congestion));
    all.front()->disconnects();  // what a clean session leaves behind makes room
    another.connects();
    all.back()->says(pingreq());
    all.back()->hears(pingresp());
}

// One that was kept for somebody who does not come makes no room before it has expired.
TEST_P(S5_3_10_Congestion, s6_3_KeptSessionsMakeRoomOnceTheyExpire) {
    for (std::size_t n = 0; n < Narrow::sessions; ++n) connected(no_flags).disconnects();
    std::vector<Client*> others;
    const auto patience = std::chrono::steady_clock::now() + 20s;
    while (others.size() < Narrow::sessions && std::chrono::steady_clock::now() < patience) {
        Client& other = client();
        other.says(connect(other.id));
        if (other.next() == connack(accepted)) {
            others.push_back(&other);
        } else {
            std::this_thread::sleep_for(50ms);
        }
    }
    EXPECT_EQ(others.size(), Narrow::sessions);
    for (Client* other : others) other->disconnects();
}

TEST_P(S5_3_10_Congestion, g7_OneAddressUnderManyNamesTakesNoRoomFromOthers) {
    Client& restless = client();
    for (std::size_t n = 0; n < 2 * Narrow::sessions; ++n) {
        restless.says(connect(unique("name")));  // never lost by its silence: duration 0
        restless.hears(connack(accepted));
    }
    Client& another = connected();
    another.disconnects();
    restless.says(disconnect());
    restless.hears(disconnect());
}

TEST_P(S5_3_10_Congestion, s6_2c_AWillPromptBeyondAllIsRefused) {
    std::vector<Client*> all;
    for (std::size_t n = 0; n < Narrow::connecting; ++n) {
        all.push_back(&client());
        all.back()->says(connect(all.back()->id, clean | with_will));
        all.back()->hears(willtopicreq());
    }
    Client& another = client();
    another.says(connect(another.id, clean | with_will));
    another.hears(connack(congestion));
    for (Client* one : all) {  // ends the prompts
        one->says(connect(one->id));
        one->hears(connack(accepted));
        one->disconnects();
    }
}

TEST_P(S5_3_10_Congestion, s6_5b_ARegisterBeyondAllTopicsIsRefused) {
    Client& robot = connected();
    for (std::size_t n = 0; n < Narrow::topics; ++n) robot.registers(topic(std::to_string(n)));
    robot.says(register_topic(0, 9, topic("one more")));
    robot.hears(regack(0, 9, congestion));
    robot.registers(topic("0"));  // those that are there stay
    robot.disconnects();
}

TEST_P(S5_3_10_Congestion, s6_9e_ASubscribeBeyondAllIsRefused) {
    Client& robot = connected();
    for (std::size_t n = 0; n < Narrow::subscriptions; ++n) {
        robot.subscribes(topic(std::to_string(n)));
    }
    robot.says(subscribe(no_flags, 9, topic("+")));
    robot.hears(suback(no_flags, 0, 9, congestion));
    robot.subscribes(topic("0"), 2);  // one that is there may change
    robot.says(unsubscribe(no_flags, 10, topic("0")));
    robot.hears(unsuback(10));
    robot.subscribes(topic("+"));
    robot.disconnects();
}

TEST_P(S5_3_10_Congestion, s6_6b_ARetainedMessageBeyondAllIsRefused) {
    Client& robot = connected();
    // The broker's own topics count among them: as many as it takes.
    std::size_t kept = 0;
    for (; kept <= Narrow::retained; ++kept) {
        const std::string name = topic(std::to_string(kept));
        const unsigned id = robot.registers(name);
        robot.says(publish(qos1 | retain, id, 9, "kept"));
        const Octets answer = robot.next();
        if (answer == puback(id, 9, congestion)) break;
        EXPECT_EQ(answer, puback(id, 9));
        forget_retained(name);
    }
    EXPECT_LE(kept, Narrow::retained) << "no refusal";
    robot.publishes(robot.registers(topic("0")), "a passing message", 1);
    robot.disconnects();
}

TEST_P(S5_3_10_Congestion, s6_6b_AMessageThatIsTooLongIsRefused) {
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    robot.publishes(id, std::string(Narrow::payload_octets, 'x'), 1);
    robot.says(publish(qos1, id, 9, std::string(Narrow::payload_octets + 1, 'x')));
    robot.hears(puback(id, 9, not_supported));
    robot.disconnects();
}

TEST_P(S5_3_10_Congestion, s6_2c_AClientIdThatIsTooLongIsRefused) {
    Client& robot = client(std::string(Narrow::client_id_octets + 1, 'x'));
    robot.says(connect(robot.id));
    robot.hears(connack(not_supported));
}

TEST_P(S5_3_10_Congestion, g10_WhatWaitsForASleeperIsBoundedAndQos0GoesFirst) {
    Client& robot = connected();
    const unsigned id = robot.subscribes(topic(), 1);
    robot.sleeps();
    Client& publisher = connected();
    const unsigned at_publisher = publisher.registers(topic());
    publisher.publishes(at_publisher, "0", 0);
    for (std::size_t n = 1; n <= Narrow::queued + 1; ++n) {
        publisher.publishes(at_publisher, std::to_string(n), 1);
    }
    robot.says(pingreq(robot.id));
    for (std::size_t n = 1; n <= Narrow::queued; ++n) robot.takes(qos1, id, std::to_string(n));
    robot.hears(pingresp());
    robot.disconnects();
    publisher.disconnects();
}

TEST_P(S5_3_10_Congestion, s6_6d_AbandonedQos2PublishesAreForgottenOldestFirst) {
    Client& robot = connected();
    const unsigned id = robot.registers(topic());
    for (unsigned msg_id = 1; msg_id <= Narrow::unreleased + 1; ++msg_id) {
        robot.says(publish(qos2, id, msg_id, "x"));
        robot.hears(pubrec(msg_id));
    }
    for (unsigned msg_id = 1; msg_id <= Narrow::unreleased + 1; ++msg_id) {
        robot.says(pubrel(msg_id));
        robot.hears(pubcomp(msg_id));
    }
    robot.disconnects();
}

}  // namespace
}  // namespace romano::conformance::limits_test
