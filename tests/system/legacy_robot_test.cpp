// The ROMANO authors' firmware, emulated octet by octet, at three brokers and at a lone one:
// established, subscribed and moved by the operator, and none the wiser when its broker is killed.

#include "tests/system/legacy_robot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"
#include "tests/system/test_client.h"
#include "tests/temporary_folder.h"

namespace romano::system::legacy_robot_test {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;

struct OldRobot : testing::Test {
    void start(int n, std::vector<std::string> more) {
        std::vector<std::string> arguments = {"--listen", addresses.service(n)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        brokers.push_back(std::make_unique<BrokerProcess>(arguments));
        brokers.back()->wait_until_serving();
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
    /// It subscribes at QoS 0: what comes to its broker's address while nobody is there is lost.
    void is_moved_by_its_id(int broker) {
        firmware.movements.clear();
        for (int tries = 0; tries < 5 && firmware.movements.empty(); ++tries) {
            EXPECT_EQ(romano(broker, {"move", id, "front", "500ms"}), 0) << said;
            firmware.run_until([&] { return !firmware.movements.empty(); }, 2s);
        }
        EXPECT_EQ(firmware.movements.size(), 1U);
    }
    void notices_nothing() const {
        EXPECT_EQ(firmware.connects, 1);
        EXPECT_EQ(firmware.refusals, 0) << "it was sent what it does not understand";
        EXPECT_EQ(firmware.disconnects_ignored, 0);
    }

    std::string id = "0433ed81";
    TestAddresses addresses;
    std::vector<std::unique_ptr<BrokerProcess>> brokers;
    std::string said;
    LegacyRobot firmware{addresses.client(), addresses.service_endpoint(1), "0433ed81"};
};

struct LegacyFirmware : OldRobot {
    LegacyFirmware() {
        for (const int n : {1, 2, 3}) {
            start(n, {"--name", "r" + std::to_string(n), "--domain",
                      std::to_string(addresses.domain()), "--interface", "lo", "--rank",
                      std::to_string(n), "--detection-timeout-ms", "300"});
        }
    }
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
        SCOPED_TRACE(home_is_dead ? "its home is dead" : "its home lives");
        is_moved_by_its_id(2);

        EXPECT_EQ(romano(3, {"subscribe-robot", id, team}), 0) << said;
        EXPECT_TRUE(
            firmware.run_until([&] { return std::ranges::count(firmware.subscribed, team) == 1; }));
        EXPECT_EQ(romano(2, {"move", team, "back", "200ms", "--form", "legacy"}), 0) << said;
        EXPECT_TRUE(firmware.run_until([&] { return firmware.movements.size() == 2; }))
            << "by its team";

        EXPECT_EQ(romano(2, {"request", id, "telemetry", home_is_dead ? "b" : "a"}), 0) << said;
        const std::size_t before = listener.received.size();
        EXPECT_TRUE(firmware.run_until([&] {
            return listener.run_until([&] { return listener.received.size() > before; }, 20ms);
        }));
    }
    notices_nothing();
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

TEST_F(OldRobot, GoesOnWithALoneBrokerThatIsKilledAndStartedAgainOnItsStore) {
    const tests::TemporaryFolder folder;
    const std::vector<std::string> store = {"--store", folder / "store.db"};
    start(1, store);
    ASSERT_TRUE(firmware.establish());
    TestClient listener{addresses.client(), addresses.service_endpoint(1), "listener"};
    ASSERT_TRUE(listener.connect());
    ASSERT_TRUE(listener.subscribe("telemetry", mqttsn::Qos::at_least_once));
    for (const bool was_killed : {false, true}) {
        SCOPED_TRACE(was_killed ? "started again" : "at first");
        if (was_killed) {
            brokers.front()->kill_9();
            brokers.clear();
            start(1, store);
        }
        is_moved_by_its_id(1);
        EXPECT_EQ(romano(1, {"request", id, "telemetry", "a"}), 0) << said;
        const std::size_t before = listener.received.size();
        EXPECT_TRUE(firmware.run_until([&] {
            return listener.run_until([&] { return listener.received.size() > before; }, 20ms);
        }));
    }
    notices_nothing();
}

}  // namespace
}  // namespace romano::system::legacy_robot_test
