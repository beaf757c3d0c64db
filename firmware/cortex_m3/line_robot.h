// A robot on this chip whose radio is another one: ROMANO here, HDLC over a UART to the radio.
//
// It begins when the radio tells its id, and finds the nearest broker. What the robot does beside
// is its subclass's matter.
#pragma once

#include <new>

#include "firmware/cortex_m3/chip.h"
#include "firmware/radio/line.h"
#include "firmware/robot/address.h"
#include "firmware/robot/robot.h"

namespace romano::chip {

class LineRobot : public firmware::Controller {
public:
    /// For ever.
    void run() {
        start();
        print("controller: started\r\n");
        for (;;) {
            if (!robot_) wait_for_id();
            if (robot_) {
                robot_->run();
                work(*robot_);
            }
            line_.on_tick(now());
            write_line();
            if (robot_ && now_ms() >= hundred_days_ms) begin_time_anew();
            wait();
        }
    }

protected:
    /// Receives any ROMANO message in one MQTT-SN PUBLISH, 255 octets and 9; sends up to 127.
    static constexpr std::size_t largest_received = 264;
    struct Limits {
        static constexpr std::size_t datagram_octets = 136;
        static constexpr std::size_t queue_octets = 160;
        static constexpr std::size_t topics = 8;
        static constexpr std::size_t name_octets = 96;
        static constexpr std::size_t unreleased = 4;
    };
    using Robot = firmware::Robot<Limits>;

    LineRobot() = default;
    ~LineRobot() = default;

    /// The robot starts, or starts anew with the clock at zero.
    virtual void on_start(const message::RomanoId& id, std::uint64_t seed) { (void)id, (void)seed; }
    /// Once a millisecond, after the robot has done what was due.
    virtual void work(Robot& robot) = 0;

    /// While on_message() or work() runs.
    [[nodiscard]] Robot& robot() { return *robot_; }
    [[nodiscard]] static Instant now() {
        return Instant{to_duration(std::chrono::milliseconds{now_ms()})};
    }

    static void print_number(std::uint32_t number) {
        char digits[10];
        std::size_t at = sizeof digits;
        do {
            digits[--at] = static_cast<char>('0' + number % 10);
            number /= 10;
        } while (number != 0);
        print({digits + at, sizeof digits - at});
    }

private:
    static constexpr Duration repeat_after =
        to_duration(std::chrono::milliseconds{50});  // as the authors' controller
    /// Half of what ROMANO_SHORT_TIME can count.
    static constexpr std::uint64_t hundred_days_ms = 100ULL * 24 * 60 * 60 * 1000;

    void on_established() override { print("controller: established\r\n"); }

    void wait_for_id() {
        while (const auto octet = read_radio()) {
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
        settings.node.listens_to_cell = client::hears_cells;
        settings.timing.t_retry = std::chrono::seconds{2};
        for (const char digit : id_.text()) {
            settings.seed = settings.seed * 31 + static_cast<unsigned char>(digit);
        }
        on_start(id_, settings.seed);
        robot_ = new (storage_) Robot(settings, board_, *this);
    }

    /// Long before the short time ends the robot connects anew, with the clock at zero; at a moment
    /// at which the line to the radio waits for no time.
    void begin_time_anew() {
        if (line_.next_wakeup() != never) return;
        restart_clock();
        start_robot();
    }

    void write_line() {
        write_radio(line_.line_out());
        line_.clear_line_out();
    }

    // --- the board: datagrams through the radio

    static LineRobot& self(void* robot) { return *static_cast<LineRobot*>(robot); }

    static std::uint64_t board_now_ms(void*) { return now_ms(); }

    static void send(void* robot, const romano_address* to, const std::uint8_t* octets,
                     std::uint32_t size) {
        LineRobot& us = self(robot);
        us.line_.send(now(), {firmware::endpoint_of(*to), radio::unknown_dbm, {octets, size}});
        us.write_line();
    }

    static const std::uint8_t* receive(void* robot, romano_address* from, std::uint32_t* size) {
        LineRobot& us = self(robot);
        while (const auto octet = read_radio()) {
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
    static int link_dbm(void* robot, const romano_address*) { return self(robot).dbm_; }

    std::uint8_t to_send_[Limits::datagram_octets + 104];
    std::uint8_t to_receive_[largest_received];
    radio::Line line_{radio::PacketType::send_udp, to_send_, to_receive_, repeat_after};
    const romano_board board_{this, board_now_ms, send, receive, link_dbm};
    std::int8_t dbm_ = radio::unknown_dbm;
    message::RomanoId id_;
    Robot* robot_ = nullptr;
    alignas(Robot) std::uint8_t storage_[sizeof(Robot)];
};

}  // namespace romano::chip
