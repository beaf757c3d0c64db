// The controller's image on a Cortex-M3 (QEMU), its radio as a process of its own behind the UART,
// and real brokers: the robot of the paper, end to end.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"
#include "tests/temporary_folder.h"

namespace romano::system::controller_test {
namespace {

using testing::HasSubstr;

class ControllerOnCortexM3 : public testing::Test {
protected:
    void start_broker(int n) {
        brokers.push_back(std::make_unique<BrokerProcess>(std::vector<std::string>{
            "--listen", addresses.service(n), "--name", "r" + std::to_string(n), "--domain",
            std::to_string(addresses.domain()), "--interface", "lo", "--rank", std::to_string(n),
            "--detection-timeout-ms", "300", "--gateway-id", std::to_string(n), "--discovery-group",
            group()}));
        brokers.back()->wait_until_serving();
    }
    void start_controller(const std::vector<std::string>& radio_settings = {},
                          const std::string& image = CONTROLLER) {
        controller = std::make_unique<Process>(
            QEMU, std::vector<std::string>{
                      "-M", "lm3s6965evb", "-display", "none", "-monitor", "none", "-nodefaults",
                      "-net", "none", "-kernel", image, "-chardev", "stdio,id=console,signal=off",
                      "-serial", "chardev:console", "-chardev",
                      "socket,id=uart,server=on,wait=off,path=" + uart, "-serial", "chardev:uart"});
        ASSERT_NE(controller->wait_for("started"), "") << controller->errors();
        std::vector<std::string> arguments{"--uart",  uart,    "--id",    "abcd1234",
                                           "--local", host(9), "--group", group()};
        arguments.insert(arguments.end(), radio_settings.begin(), radio_settings.end());
        radio = std::make_unique<Process>(ROMANO_RADIO, arguments);
        ASSERT_NE(controller->wait_for("established"), "") << radio->errors();
    }
    /// `romano COMMAND -h <broker n>`; what it said.
    std::string romano(int n, std::vector<std::string> arguments) {
        arguments.insert(arguments.begin() + 1, {"-h", host(n), "-p", "18830"});
        Process program(ROMANO_PROGRAM, arguments);
        std::string said = program.rest_of_output();
        EXPECT_EQ(program.wait_for_exit(), 0) << program.errors();
        return said;
    }
    [[nodiscard]] std::string host(int n) const {
        const std::string service = addresses.service(n);
        return service.substr(0, service.find(':'));
    }
    [[nodiscard]] std::string group() const {
        return "225.1.1.1:" + std::to_string(18'000 + addresses.domain());
    }

    TestAddresses addresses;
    tests::TemporaryFolder folder;
    std::string uart = folder / "uart";
    std::vector<std::unique_ptr<BrokerProcess>> brokers;
    std::unique_ptr<Process> controller;
    std::unique_ptr<Process> radio;
};

TEST_F(ControllerOnCortexM3, FindsABrokerAndCarriesCommandsOut) {
    start_broker(1);
    start_controller();
    EXPECT_THAT(romano(1, {"robots"}), HasSubstr("abcd1234"));
    romano(1, {"move", "abcd1234", "front", "100mm"});
    EXPECT_NE(controller->wait_for("front 100"), "");
    romano(1, {"move", "abcd1234", "rotate-left", "90deg", "-q", "2"});
    EXPECT_NE(controller->wait_for("rotate-left 90000"), "");
}

TEST_F(ControllerOnCortexM3, GoesOnWhenItsHomeIsKilled) {
    start_broker(1);
    start_broker(2);
    start_controller();
    const bool first =
        romano(1, {"robots", "--json"}).find("\"home\": \"r1\"") != std::string::npos;
    brokers[first ? 0 : 1]->kill_9();
    const int survivor = first ? 2 : 1;
    for (int i = 1; i <= 5; ++i) {
        romano(survivor, {"move", "abcd1234", "front", std::to_string(i) + "mm", "-q", "2"});
        EXPECT_NE(controller->wait_for("front " + std::to_string(i)), "");
    }
}

TEST_F(ControllerOnCortexM3, ABadLineBetweenControllerAndRadioLosesNothing) {
    start_broker(1);
    start_controller({"--bit-errors", "1.5e-3"});
    for (int i = 1; i <= 10; ++i) {
        romano(1, {"move", "abcd1234", "back", std::to_string(i) + "mm", "-q", "1"});
        EXPECT_NE(controller->wait_for("back " + std::to_string(i)), "");
    }
    radio->signal(SIGTERM);
    EXPECT_THAT(radio->wait_for("frames heard"), testing::Not(HasSubstr(" 0 bad, 0 repeated")));
}

TEST_F(ControllerOnCortexM3, ConnectsAnewBeforeItsClockEnds) {
    start_broker(1);
    start_controller({}, OLD_CONTROLLER);
    EXPECT_NE(controller->wait_for("established"),
              "");  // once more, when the hundred days are over
    romano(1, {"move", "abcd1234", "front", "100mm"});
    EXPECT_NE(controller->wait_for("front 100"), "");
}

}  // namespace
}  // namespace romano::system::controller_test
