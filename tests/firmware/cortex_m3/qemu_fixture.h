// An image on a Cortex-M3 (QEMU), its radio as a process of its own behind the UART, and real
// brokers: the robot of the paper, end to end.
#pragma once

#include <gmock/gmock.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/system/broker_fixture.h"
#include "tests/system/process.h"
#include "tests/temporary_folder.h"

namespace romano::system {

struct QemuFixture : BrokerFixture {
    void start_broker(int n, const std::vector<std::string>& more = {}) {
        std::vector<std::string> arguments{"--gateway-id", std::to_string(n), "--discovery-group",
                                           group()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        start_member(n, arguments);
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

    tests::TemporaryFolder folder;
    std::string uart = folder / "uart";
    std::unique_ptr<Process> controller;
    std::unique_ptr<Process> radio;
};

}  // namespace romano::system
