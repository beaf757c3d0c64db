// The ROMANO authors' firmware, emulated octet by octet, at three brokers: established, subscribed
// and moved by the operator, and none the wiser when its home is killed.

#include "tests/system/legacy_robot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"
#include "tests/system/test_client.h"

namespace romano::system {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;

struct LegacyFirmware : testing::Test {
    LegacyFirmware() {
        for (const int n : {1, 2, 3}) {
            brokers.push_back(std::make_unique<BrokerProcess>(std::vector<std::string>{
                "--listen", addresses.service(n), "--name", "r" + std::to_string(n), "--domain",
                std::to_string(addresses.domain()), "--interface", "lo", "--rank",
                std::to_string(n), "--detection-timeout-ms", "300"}));
            brokers.back()->wait_until_serving();
        }
    }
    /// `romano COMMAND` at that broker; its exit code. The robot goes on meanwhile.
    int romano(int broker, std::vector<std::string> arguments) {
        const std::string service = addresses.service(broker);
        const auto colon = service.find(':');
        arguments.insert(arguments.begin() + 1,
                         {"-h", service.substr(0, colon), "-p", service.substr(colon + 1)});
        Process program(ROMANO_PROGRAM, arguments);
        said = program.rest_of_output();
        const int code = program.wait_for_exit();
        said += program.errors();
        return code;
    }
    /// Until that broker knows of the robot.
    void wait_until_listed(int broker) {
        said.clear();
        for (int i = 0; i < 100 && said.find(id) == std::string::npos; ++i) {
            ASSERT_EQ(romano(broker, {"robots"}), 0) << said;
        }
    }

    std::string id = "0433ed81";
    TestAddresses addresses;
    std::vector<std::unique_ptr<BrokerProcess>> brokers;
    std::string said;
    LegacyRobot firmware{addresses.client(), addresses.service_endpoint(1), "0433ed81"};
};

TEST_F(LegacyFirmware, GoesThroughEverythingThoughItsHomeIsKilled) {
    ASSERT_TRUE(firmware.establish());
    EXPECT_EQ(firmware.delivered[0].data, "ACK");
    wait_until_listed(2);
    wait_until_listed(3);
    TestClient listener{addresses.client(), addresses.service_endpoint(3), "listener"};
    ASSERT_TRUE(listener.connect());
    ASSERT_TRUE(listener.subscribe("telemetry", mqttsn::Qos::at_least_once));

    for (const bool home_is_dead : {false, true}) {
        if (home_is_dead) brokers[0]->kill_9();
        const std::string team = home_is_dead ? "team/red" : "team/blue";
        firmware.movements.clear();
        // It subscribes at QoS 0: what comes to its home's address before the heir is there is
        // lost.
        for (int tries = 0; tries < 5 && firmware.movements.empty(); ++tries) {
            EXPECT_EQ(romano(2, {"move", id, "front", "500ms"}), 0) << said;
            firmware.run_until([&] { return !firmware.movements.empty(); }, 2s);
        }
        ASSERT_EQ(firmware.movements.size(), 1U) << "by its id; home is dead: " << home_is_dead;

        EXPECT_EQ(romano(3, {"subscribe-robot", id, team}), 0) << said;
        EXPECT_TRUE(
            firmware.run_until([&] { return std::ranges::count(firmware.subscribed, team) == 1; }));
        EXPECT_EQ(romano(2, {"move", team, "back", "200ms", "--form", "legacy"}), 0) << said;
        EXPECT_TRUE(firmware.run_until([&] { return firmware.movements.size() == 2; }))
            << "by its team; home is dead: " << home_is_dead;

        EXPECT_EQ(romano(2, {"request", id, "telemetry", home_is_dead ? "b" : "a"}), 0) << said;
        const std::size_t before = listener.received.size();
        EXPECT_TRUE(firmware.run_until([&] {
            return listener.run_until([&] { return listener.received.size() > before; }, 20ms);
        }));
    }
    EXPECT_EQ(firmware.connects, 1);
    EXPECT_EQ(firmware.refusals, 0) << "it was sent what it does not understand";
    EXPECT_EQ(firmware.disconnects_ignored, 0);
}

TEST_F(LegacyFirmware, WhoseHomeDiesBeforeTheAcknowledgementIsAnsweredByTheHeir) {
    // Until the brokers know each other, nobody takes over.
    LegacyRobot first{addresses.client(), addresses.service_endpoint(1), "0433ed82"};
    ASSERT_TRUE(first.establish());
    id = "0433ed82";
    wait_until_listed(2);
    wait_until_listed(3);
    brokers[0]->kill_9();
    ASSERT_TRUE(firmware.establish());
    EXPECT_EQ(firmware.delivered[0].data, "ACK");
    // An acknowledgement for each hello and no more: what comes late is of no harm either.
    (void)firmware.run_until([] { return false; }, 300ms);
    EXPECT_LE(firmware.delivered.size(), static_cast<std::size_t>(firmware.hellos));
    EXPECT_EQ(firmware.connects, 1);
}

}  // namespace
}  // namespace romano::system
