// The controller's image: it finds a broker, carries commands out, and outlives what a robot does.

#include <gmock/gmock.h>

#include <string>

#include "tests/firmware/cortex_m3/qemu_fixture.h"
#include "tests/system/metrics_page.h"

namespace romano::system::controller_test {
namespace {

using testing::HasSubstr;

class ControllerOnCortexM3 : public QemuFixture {};

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

TEST_F(ControllerOnCortexM3, HearsWhatItsBrokerSendsOnceForMany) {
    const std::string cell = "239.18.83.1:" + std::to_string(17'000 + addresses.domain());
    const std::string metrics = addresses.service(2);
    start_broker(1, {"--cell-group", cell, "--metrics", metrics});
    start_controller({"--cell-group", cell}, CELL_CONTROLLER);
    Process beside(ROMANO_ROBOT,
                   {"--id", "00000007", "--broker", addresses.service(1), "--cell-group", cell});
    ASSERT_NE(beside.wait_for("established"), "") << "one listener alone is sent unicasts";
    for (int i = 1; i <= 3; ++i) {
        romano(1, {"move", "common", "front", std::to_string(i) + "mm", "-q", "1"});
        EXPECT_NE(controller->wait_for("front " + std::to_string(i)), "");
    }
    EXPECT_TRUE(
        metrics_come_to_say(addresses.service_endpoint(2), "romano_cell_deliveries_total", 2, 1e9));
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
