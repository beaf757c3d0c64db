// A movement controller in C++: takes commands from ROMANO's mailbox, "moves", and tells how far it
// has come when somebody asks for its `odometer`.
//
//     controller_cpp abcd1234 127.0.0.1 1883 [COMMANDS]    ends after so many commands, if given
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "firmware/posix/udp_board.h"
#include "firmware/robot/address.h"
#include "firmware/robot/robot.h"

namespace {

using namespace romano;
using namespace std::chrono_literals;

class Wheels final : public firmware::Controller {
public:
    void drive(firmware::RobotCore& robot) { robot_ = &robot; }

    void move(const romano_command& command) {
        driven_mm_ += romano_command_amount(&command);
        std::printf("movement %u, %u mm so far\n", unsigned{command.type}, driven_mm_);
        std::fflush(stdout);
    }

private:
    void on_publish_request(std::string_view topic, Bytes kind) override {
        if (as_text(kind) != "odometer") return;
        const std::string text = std::to_string(driven_mm_);
        robot_->publish(topic, message::NormalData{as_octets(text)}, mqttsn::Qos::at_least_once);
    }

    firmware::RobotCore* robot_ = nullptr;
    std::uint32_t driven_mm_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
    romano_address broker{};
    const auto id = message::RomanoId::parse(argc > 1 ? argv[1] : "");
    if (argc < 4 || !id ||
        !romano_udp_address(argv[2], static_cast<std::uint16_t>(std::atoi(argv[3])), &broker)) {
        std::fprintf(stderr, "usage: controller_cpp ID BROKER-IP PORT [COMMANDS]\n");
        return 2;
    }
    romano_address local{};
    local.family = broker.family;
    romano_udp_board udp;
    if (romano_udp_open(&udp, &local) != 0) return 1;

    firmware::RobotSettings settings;
    settings.node.id = *id;
    settings.broker = firmware::endpoint_of(broker);
    Wheels wheels;
    firmware::Robot<> robot{settings, udp.board, wheels};
    wheels.drive(robot);
    for (long left = argc > 4 ? std::atol(argv[4]) : -1; left != 0;) {
        const Instant next = std::max(robot.run(), robot.now());
        for (romano_command command; left != 0 && robot.next_command(command); --left) {
            wheels.move(command);
        }
        const auto wait = std::clamp<Duration>(next - robot.now(), 0ms, 10s);
        if (left != 0) {
            romano_udp_wait(&udp, static_cast<std::uint32_t>(wait / 1ms) + 1);
        }
    }
    robot.run();  // acknowledges the last one
    robot.leave();
    romano_udp_close(&udp);
}
