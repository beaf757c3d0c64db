// The controller of a robot as in the paper: ROMANO and the movement controller here, the radio on
// another chip behind HDLC over a UART. No operating system, no heap, no C library but memcpy.
//
// It prints each command to the console where a real robot turns its wheels.

#include "firmware/cortex_m3/line_robot.h"

namespace {

using namespace romano;

class MovementController final : public chip::LineRobot {
    void work(Robot& robot) override {
        for (romano_command command; robot.next_command(command);) {
            static constexpr std::string_view names[] = {"front", "back",        "left",
                                                         "right", "rotate-left", "rotate-right"};
            chip::print(command.type < 6 ? names[command.type] : "movement");
            chip::print(" ");
            print_number(romano_command_amount(&command));
            chip::print("\r\n");
        }
    }
};

alignas(MovementController) std::uint8_t storage[sizeof(MovementController)];

}  // namespace

int main() {
    (new (storage) MovementController)->run();
    return 0;
}
