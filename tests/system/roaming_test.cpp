// Firmware that knows one fixed broker address: every broker serves that address in its own cell,
// and the session follows the robot from cell to cell.

#include <gtest/gtest.h>

#include <memory>
#include <thread>

#include "broker/net/endpoint_text.h"
#include "experiments/process/lan.h"
#include "tests/system/broker_process.h"
#include "tests/system/test_client.h"

namespace romano::system::roaming_test {
namespace {

using namespace std::chrono_literals;
using experiments::Lan;
using mqttsn::Qos;

constexpr int brokers_in_all = 3;
constexpr int rover = brokers_in_all + 1;

class OneAddressInEveryCell : public testing::Test {
protected:
    void SetUp() override {
        lan.add_cells(brokers_in_all);
        if (!lan.why_not().empty()) GTEST_SKIP() << lan.why_not();
        for (int host = 1; host <= brokers_in_all; ++host) {
            const Lan::On on(lan, host);
            brokers.push_back(std::make_unique<BrokerProcess>(std::vector<std::string>{
                "--listen", service, "--allow-plain", "--name", "r" + std::to_string(host),
                "--domain", "7", "--interface", "eth0", "--rank", std::to_string(host),
                "--detection-timeout-ms", "500"}));
            brokers.back()->wait_until_serving();
        }
        for (const auto& broker : brokers) ASSERT_TRUE(is_in_view_of_all(*broker));
    }
    static bool is_in_view_of_all(BrokerProcess& broker) {
        const auto deadline = std::chrono::steady_clock::now() + 20s;
        while (broker.errors().find(" of 3, led by ") == std::string::npos) {
            if (std::chrono::steady_clock::now() > deadline) return false;
            std::this_thread::sleep_for(10ms);
        }
        return true;
    }
    [[nodiscard]] std::unique_ptr<TestClient> client(int host, const std::string& id) const {
        const Lan::On on(lan, host);
        auto made = std::make_unique<TestClient>(*net::parse_endpoint("0.0.0.0:0"),
                                                 *net::parse_endpoint(service), id);
        made->repeats_after = 200ms;
        return made;
    }
    /// What the robot hears of the station now.
    static bool hears(TestClient& robot, TestClient& station, mqttsn::TopicId topic,
                      const std::string& data) {
        if (!station.publish(topic, data, Qos::exactly_once)) return false;
        return robot.run_until(
            [&] { return !robot.received.empty() && robot.received.back().data == data; });
    }

    const std::string service = std::string{Lan::cell_address} + ":1883";
    Lan lan{brokers_in_all};
    std::vector<std::unique_ptr<BrokerProcess>> brokers;
};

TEST_F(OneAddressInEveryCell, TheSessionFollowsTheRobotAndOutlivesItsHome) {
    const auto station = client(3, "station");  // beside the third broker, in its cell
    ASSERT_TRUE(station->connect());
    const auto topic = station->register_topic("robot/go");
    ASSERT_TRUE(topic);
    const auto robot = client(rover, "robot");
    ASSERT_TRUE(robot->connect());
    ASSERT_TRUE(robot->subscribe("robot/go", Qos::exactly_once));
    const int begun = robot->sessions_begun;
    ASSERT_TRUE(hears(*robot, *station, *topic, "in the first cell"));

    lan.drive_to(2);
    ASSERT_TRUE(robot->ping()) << "whatever it says first, its new broker hears";
    EXPECT_TRUE(hears(*robot, *station, *topic, "in the second cell"));
    lan.drive_to(1);
    ASSERT_TRUE(robot->ping());
    EXPECT_TRUE(hears(*robot, *station, *topic, "in the first cell again"));

    brokers[0]->kill_9();
    lan.drive_to(2);
    ASSERT_TRUE(robot->ping());
    EXPECT_TRUE(hears(*robot, *station, *topic, "after its home has died"));
    EXPECT_EQ(robot->received.size(), 4U) << "each once";
    EXPECT_EQ(robot->sessions_begun, begun) << "it had to connect or subscribe again";
}

TEST_F(OneAddressInEveryCell, WhatWasPublishedOnTheWayArrivesInTheNextCell) {
    const auto station = client(3, "station");
    ASSERT_TRUE(station->connect());
    const auto topic = station->register_topic("robot/go");
    const auto robot = client(rover, "robot");
    ASSERT_TRUE(robot->connect());
    ASSERT_TRUE(robot->subscribe("robot/go", Qos::exactly_once));
    ASSERT_TRUE(hears(*robot, *station, *topic, "0"));
    lan.drive_to(2);
    for (int i = 1; i <= 20; ++i) {
        ASSERT_TRUE(station->publish(*topic, std::to_string(i), Qos::exactly_once));
    }
    ASSERT_TRUE(robot->ping());
    ASSERT_TRUE(robot->run_until([&] { return robot->received.size() >= 21; }));
    for (int i = 0; i <= 20; ++i) {
        EXPECT_EQ(robot->received[static_cast<std::size_t>(i)].data, std::to_string(i));
    }
}

}  // namespace
}  // namespace romano::system::roaming_test
