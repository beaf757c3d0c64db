// Loops between real robots through real brokers, opened by the operator's program.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "tests/system/broker_fixture.h"
#include "tests/system/process.h"
#include "tests/system/test_client.h"

namespace romano::system::control_test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

struct Loops : BrokerFixture {
    std::unique_ptr<Process> start_robot(const std::string& id, int broker) const {
        auto robot = std::make_unique<Process>(
            ROMANO_ROBOT,
            std::vector<std::string>{"--id", id, "--broker", addresses.service(broker)});
        EXPECT_NE(robot->wait_for("established"), "");
        return robot;
    }
    std::unique_ptr<Process> start_in_c(const std::string& role, const std::string& id) const {
        const auto [host, port] = at(1);
        auto robot =
            std::make_unique<Process>(LOOP_C, std::vector<std::string>{role, id, host, port});
        EXPECT_NE(robot->wait_for("established"), "");
        return robot;
    }
    [[nodiscard]] std::pair<std::string, std::string> at(int broker) const {
        const std::string service = addresses.service(broker);
        const auto colon = service.find(':');
        return {service.substr(0, colon), service.substr(colon + 1)};
    }
    /// `romano control -h <broker> ...`
    [[nodiscard]] std::unique_ptr<Process> control(int broker,
                                                   std::vector<std::string> arguments) const {
        const auto [host, port] = at(broker);
        arguments.insert(arguments.begin(), {"control", "-h", host, "-p", port});
        return std::make_unique<Process>(ROMANO_PROGRAM, arguments);
    }
    /// To its end; its exit code, and its output in `said`.
    int romano_control(std::vector<std::string> arguments) {
        const auto program = control(1, std::move(arguments));
        said = program->rest_of_output();
        const int code = program->wait_for_exit();
        said += program->errors();
        return code;
    }

    /// Of the plant's own counts, as it has reported them last.
    [[nodiscard]] long number(const std::string& name) const {
        const auto at = said.find('"' + name + "\":");
        EXPECT_NE(at, std::string::npos) << said;
        return at == std::string::npos ? -1 : std::stol(said.substr(at + name.size() + 3));
    }
    /// The same, of a report that is asked for now.
    long count(const std::string& name) {
        EXPECT_EQ(romano_control({plant, "--json"}), 0) << said;
        return number(name);
    }

    std::string said;
    const std::string plant = "00000002";
    const std::string leader = "00000001";
    // A machine that is busy with other tests must not break a loop.
    const std::vector<std::string> patient = {plant, leader,          "--period-ms",
                                              "100", "--deadline-ms", "3000"};
};

TEST_F(Loops, ARobotControlsAnotherUntilTheOperatorEndsIt) {
    start_broker(1);
    const auto controller = start_robot(leader, 1);
    const auto robot = start_robot(plant, 1);
    std::vector<std::string> arguments = patient;
    arguments.insert(arguments.end(), {"--law", "go-to", "--to", "200,0", "--seconds", "2"});
    EXPECT_EQ(romano_control(arguments), 0) << said;
    EXPECT_THAT(said, HasSubstr("00000002 controlled by 00000001: "));
    EXPECT_THAT(said, HasSubstr("00000002 free, controller 00000001: "));
    EXPECT_NE(controller->wait_for("controls 00000002"), "");
    EXPECT_NE(robot->wait_for("is to be controlled by 00000001"), "");
    EXPECT_NE(robot->wait_for("is controlled by 00000001"), "");
    EXPECT_NE(robot->wait_for("is no longer controlled by 00000001: ended by a node"), "");
    EXPECT_NE(controller->wait_for("no longer controls 00000002: ended by a node"), "");
}

TEST_F(Loops, APlantWhoseControllerIsKilledFallsBackAndIsControlledAgainByItsSuccessor) {
    start_broker(1);
    auto controller = start_robot(leader, 1);
    const auto robot = start_robot(plant, 1);
    std::vector<std::string> arguments = patient;
    arguments.back() = "1000";
    const auto supervisor = control(1, arguments);
    ASSERT_NE(robot->wait_for("is controlled by"), "");
    controller->kill_9();
    EXPECT_NE(robot->wait_for("is not controlled by 00000001 now"), "");
    controller = start_robot(leader, 1);
    EXPECT_NE(robot->wait_for("is controlled by"), "");
    supervisor->signal(SIGINT);
    EXPECT_EQ(supervisor->wait_for_exit(), 0);
    EXPECT_NE(robot->wait_for("is no longer controlled by 00000001: ended by a node"), "");
}

/// It answers all that came meanwhile, and what is old by then is late.
TEST_F(Loops, AControllerThatStoodStillGoesOnAndItsOldCommandsAreNotCarriedOut) {
    start_broker(1);
    const auto controller = start_robot(leader, 1);
    const auto robot = start_robot(plant, 1);
    const auto supervisor =
        control(1, {plant, leader, "--period-ms", "40", "--deadline-ms", "600"});
    ASSERT_NE(robot->wait_for("is controlled by"), "");
    controller->signal(SIGSTOP);
    EXPECT_NE(robot->wait_for("is not controlled by 00000001 now"), "");
    usleep(200'000);  // so long it stands still beyond the deadline
    controller->signal(SIGCONT);
    EXPECT_NE(robot->wait_for("is controlled by"), "");
    EXPECT_GE(count("fell_back"), 1);
    EXPECT_GE(number("late"), 1);
    EXPECT_EQ(number("repeated"), 0);
}

/// Somebody listened to all that was said to the plant, and says it again.
TEST_F(Loops, WhatIsReplayedFromACaptureMovesNobody) {
    constexpr char command = 9;
    start_broker(1);
    TestClient capture(addresses.client(), addresses.service_endpoint(1), "capture");
    ASSERT_TRUE(capture.connect());
    ASSERT_TRUE(capture.subscribe(plant, mqttsn::Qos::at_most_once));
    const auto controller = start_robot(leader, 1);
    const auto robot = start_robot(plant, 1);
    std::vector<std::string> arguments = patient;
    arguments.insert(arguments.end(), {"--law", "go-to", "--to", "200,0", "--detach"});
    ASSERT_EQ(romano_control(arguments), 0) << said;
    const auto is_command = [](const ReceivedPublish& message) {
        return message.data.size() > 3 && message.data[2] == command;
    };
    ASSERT_TRUE(capture.run_until(
        [&] { return std::ranges::count_if(capture.received, is_command) >= 10; }));
    const std::vector<ReceivedPublish> captured = capture.received;
    const auto commands = std::ranges::count_if(captured, is_command);
    const auto topic = capture.register_topic(plant);
    ASSERT_TRUE(topic);
    const auto replay = [&] {
        for (const ReceivedPublish& message : captured) {
            ASSERT_TRUE(capture.publish(*topic, message.data, mqttsn::Qos::at_least_once));
        }
    };
    const auto refused = [&] { return count("repeated") + number("late") + number("foreign"); };
    const auto come_to_be_refused = [&](long more) {
        for (int tries = 0; tries < 100 && refused() < more; ++tries) usleep(100'000);
        return refused() >= more;
    };
    replay();
    EXPECT_TRUE(come_to_be_refused(commands)) << said;
    EXPECT_LE(number("carried_out"), number("samples"));
    EXPECT_EQ(romano_control({plant, "--end"}), 0) << said;
    const long carried_out = count("carried_out");
    replay();  // with the opening of that loop among it; the plant hears it before the question
    EXPECT_EQ(count("carried_out"), carried_out);
    EXPECT_THAT(said, HasSubstr(R"("state":"free")"));
}

TEST_F(Loops, ALoopOutlivesTheBrokerOfBothRobots) {
    start_member(1);
    start_member(2);
    const auto controller = start_robot(leader, 1);
    const auto robot = start_robot(plant, 1);
    const auto supervisor = control(2, patient);
    ASSERT_NE(robot->wait_for("is controlled by"), "");
    ASSERT_NE(supervisor->wait_for("controlled by"), "");
    brokers[0]->kill_9();
    for (int seconds = 0; seconds < 5; ++seconds) {
        EXPECT_THAT(supervisor->wait_for("controlled by"), HasSubstr("fell back 0 times"));
    }
    supervisor->signal(SIGINT);
    EXPECT_EQ(supervisor->wait_for_exit(), 0);
}

TEST_F(Loops, ALoopThatNobodyRenewsEndsWithItsLease) {
    start_broker(1);
    const auto controller = start_robot(leader, 1);
    const auto robot = start_robot(plant, 1);
    const auto supervisor = control(1, patient);
    ASSERT_NE(robot->wait_for("is controlled by"), "");
    supervisor->kill_9();
    EXPECT_NE(robot->wait_for("is no longer controlled by 00000001: the lease is over"), "");
}

TEST_F(Loops, ADetachedLoopGoesOnAndIsEndedByAnybody) {
    start_broker(1);
    const auto controller = start_robot(leader, 1);
    const auto robot = start_robot(plant, 1);
    std::vector<std::string> arguments = patient;
    arguments.emplace_back("--detach");
    EXPECT_EQ(romano_control(arguments), 0) << said;
    ASSERT_NE(robot->wait_for("is controlled by"), "");
    EXPECT_EQ(romano_control({plant, "--json"}), 0) << said;
    EXPECT_THAT(said, HasSubstr(R"("state":"controlled")"));
    EXPECT_EQ(romano_control(patient), 2);
    EXPECT_THAT(said, HasSubstr("00000002 is in a loop already, with 00000001"));
    EXPECT_EQ(romano_control({plant, "--end"}), 0) << said;
    EXPECT_NE(robot->wait_for("is no longer controlled by"), "");
}

TEST_F(Loops, WhatCannotBeIsOneSentence) {
    start_broker(1);
    const auto controller = start_robot(leader, 1);
    const auto robot = start_robot(plant, 1);
    EXPECT_EQ(romano_control({plant, leader, "--deadline-ms", "10"}), 2);
    EXPECT_THAT(said, HasSubstr("--deadline-ms 10: must be more than --period-ms, which is 20"));
    EXPECT_EQ(romano_control({plant, leader, "--law", "9"}), 2);
    EXPECT_THAT(said, HasSubstr("the controller has no such law"));
    EXPECT_EQ(romano_control({plant, leader, "--fallback", "own-law"}), 2);
    EXPECT_THAT(said, HasSubstr("the robot itself says no"));
    EXPECT_EQ(romano_control({plant, "0000000x"}), 2);
    EXPECT_THAT(said, HasSubstr("controller `0000000x`: must be the id of a robot"));
    EXPECT_EQ(romano_control({"--broker-timeout", "2", "00000009"}), 2);
    EXPECT_THAT(said, HasSubstr("00000009 does not answer"));
}

TEST_F(Loops, PlantAndLawCanBeInC) {
    start_broker(1);
    const auto law = start_in_c("law", leader);
    const auto cart = start_in_c("cart", plant);
    std::vector<std::string> arguments = patient;
    arguments.insert(arguments.end(), {"--law", "7"});
    const auto supervisor = control(1, arguments);
    EXPECT_NE(law->wait_for("controls 00000002"), "");
    EXPECT_NE(cart->wait_for("the cart has arrived"), "");
    law->kill_9();
    EXPECT_NE(cart->wait_for("the cart falls back"), "");
}

}  // namespace
}  // namespace romano::system::control_test
