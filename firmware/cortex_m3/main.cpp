// The controller of a robot as in the paper: ROMANO and the movement controller here, the radio on
// another chip behind HDLC over a UART. No operating system, no heap, no C library but memcpy.
//
// It begins when the radio tells its id, finds the nearest broker, and prints each command to the
// console where a real robot turns its wheels.

#include <new>

#include "firmware/cortex_m3/chip.h"
#include "firmware/radio/line.h"
#include "firmware/robot/address.h"
#include "firmware/robot/robot.h"

namespace {

using namespace romano;

constexpr Duration repeat_after =
    to_duration(std::chrono::milliseconds{50});  // as the authors' controller

/// Half of what ROMANO_SHORT_TIME can count.
constexpr std::uint64_t hundred_days_ms = 100ULL * 24 * 60 * 60 * 1000;

/// Receives any ROMANO message in one MQTT-SN PUBLISH, 255 octets and 9; sends up to 127.
constexpr std::size_t largest_received = 264;
struct ControllerLimits {
    static constexpr std::size_t datagram_octets = 136;
    static constexpr std::size_t queue_octets = 160;
    static constexpr std::size_t topics = 8;
    static constexpr std::size_t name_octets = 96;
    static constexpr std::size_t unreleased = 4;
};

std::uint8_t to_send[ControllerLimits::datagram_octets + 104];
std::uint8_t to_receive[largest_received];

class Controller final : public firmware::Controller {
public:
    void run() {
        chip::start();
        chip::print("controller: started\r\n");
        for (;;) {
            if (!robot_) wait_for_id();
            if (robot_) {
                robot_->run();
                carry_out_commands();
            }
            line_.on_tick(now());
            write_line();
            if (robot_ && chip::now_ms() >= hundred_days_ms) begin_time_anew();
            chip::wait();
        }
    }

private:
    using Robot = firmware::Robot<ControllerLimits>;

    void on_established() override { chip::print("controller: established\r\n"); }

    void wait_for_id() {
        while (const auto octet = chip::read_radio()) {
            const auto input = line_.on_octet(now(), *octet);
            write_line();
            if (!input.packet || input.packet->type != radio::PacketType::hwaddr_get) continue;
            const auto id = message::RomanoId::parse(as_text(input.packet->body));
            if (!id) continue;
            (void)line_.send_packet(now(), radio::PacketType::hwaddr_ack, {});
            write_line();
            id_ = *id;
            start_robot();
            return;
        }
    }

    void start_robot() {
        firmware::RobotSettings settings;
        settings.node.id = id_;
        settings.timing.t_retry = std::chrono::seconds{2};
        for (const char digit : id_.text()) {
            settings.seed = settings.seed * 31 + static_cast<unsigned char>(digit);
        }
        robot_ = new (storage_) Robot(settings, board_, *this);
    }

    /// Long before the short time ends the robot connects anew, with the clock at zero; at a moment
    /// at which the line to the radio waits for no time.
    void begin_time_anew() {
        if (line_.next_wakeup() != never) return;
        chip::restart_clock();
        start_robot();
    }

    void carry_out_commands() {
        for (romano_command command; robot_->next_command(command);) {
            static constexpr std::string_view names[] = {"front", "back",        "left",
                                                         "right", "rotate-left", "rotate-right"};
            chip::print(command.type < 6 ? names[command.type] : "movement");
            chip::print(" ");
            print_number(romano_command_amount(&command));
            chip::print("\r\n");
        }
    }

    static void print_number(std::uint32_t number) {
        char digits[10];
        std::size_t at = sizeof digits;
        do {
            digits[--at] = static_cast<char>('0' + number % 10);
            number /= 10;
        } while (number != 0);
        chip::print({digits + at, sizeof digits - at});
    }

    void write_line() {
        chip::write_radio(line_.line_out());
        line_.clear_line_out();
    }

    // --- the board: datagrams through the radio

    static Controller& self(void* controller) { return *static_cast<Controller*>(controller); }

    static std::uint64_t now_ms(void*) { return chip::now_ms(); }
    static Instant now() { return Instant{to_duration(std::chrono::milliseconds{chip::now_ms()})}; }

    static void send(void* controller, const romano_address* to, const std::uint8_t* octets,
                     std::uint32_t size) {
        Controller& us = self(controller);
        us.line_.send(now(), {firmware::endpoint_of(*to), radio::unknown_dbm, {octets, size}});
        us.write_line();
    }

    static const std::uint8_t* receive(void* controller, romano_address* from,
                                       std::uint32_t* size) {
        Controller& us = self(controller);
        while (const auto octet = chip::read_radio()) {
            const auto input = us.line_.on_octet(now(), *octet);
            us.write_line();
            if (!input.datagram) continue;
            us.dbm_ = input.datagram->dbm;
            *from = firmware::address_of(input.datagram->peer);
            *size = static_cast<std::uint32_t>(input.datagram->octets.size());
            return input.datagram->octets.data();
        }
        return nullptr;
    }

    /// Of the datagram that was received last, which is the one that is asked about.
    static int link_dbm(void* controller, const romano_address*) { return self(controller).dbm_; }

    radio::Line line_{radio::PacketType::send_udp, to_send, to_receive, repeat_after};
    const romano_board board_{this, now_ms, send, receive, link_dbm};
    std::int8_t dbm_ = radio::unknown_dbm;
    message::RomanoId id_;
    Robot* robot_ = nullptr;
    alignas(Robot) std::uint8_t storage_[sizeof(Robot)];
};

alignas(Controller) std::uint8_t storage[sizeof(Controller)];

}  // namespace

int main() {
    (new (storage) Controller)->run();
    return 0;
}
