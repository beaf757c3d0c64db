// A ROMANO robot without wheels: the firmware's robot on a UDP socket, with a simulated body. It
// prints what it is told and publishes where it is; others may control it, and it others.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "broker/net/core_timer.h"
#include "firmware/posix/body.h"
#include "firmware/posix/keyed_board.h"
#include "firmware/posix/radio_board.h"
#include "firmware/posix/simulated_loops.h"
#include "firmware/posix/udp_board.h"
#include "firmware/robot/robot.h"
#include "romano/keys/client_packets.h"

namespace romano::firmware {

struct SimulatedRobotOptions {
    RobotSettings robot;
    romano_address local{};       // family 0: any address of the broker's family
    romano_address group{};       // of discovery; family 0: the usual one
    romano_address cell_group{};  // heard too; family 0: none
    std::string telemetry_topic;  // empty: none
    Duration telemetry_every{std::chrono::seconds{1}};
    std::vector<std::string> subscriptions;
    std::string follow;  // copies the path of the locations on this topic; empty: none
    Pose start;
    std::filesystem::path key_file;               // empty: speaks plain
    keys::Speech speech = keys::Speech::packets;  // with the key
    Radio* radio = nullptr;  // null: every datagram gets through, and nobody tells how strongly
    /// What nobody here carries out is told to it before it is printed; true: it is not printed.
    std::function<bool(std::string_view topic, const message::Message& message)> hears = {};
};

/// Throws std::invalid_argument with a sentence when no broker could take one of the topics.
void check_topics(const SimulatedRobotOptions& options);

struct RobotCounters {
    std::uint64_t commands = 0;
    std::uint64_t messages = 0;
    std::uint64_t established = 0;
    std::uint64_t telemetry = 0;
};

class SimulatedRobot final : private Controller {
public:
    /// One line without its end for each thing that happens: "front 100 mm (x 100 mm, ...)".
    using Say = std::function<void(const message::RomanoId& id, const std::string& what)>;

    /// Throws std::runtime_error when the socket cannot be opened.
    SimulatedRobot(boost::asio::io_context& io, const SimulatedRobotOptions& options, Say say);
    ~SimulatedRobot();

    /// As of RobotCore, at once. Not to be called from `hears` or `say`.
    bool publish(std::string_view topic, const message::Message& message, mqttsn::Qos qos);
    /// Says goodbye to the broker. `left` is called when it has confirmed that, or has not within
    /// 1.5 seconds, in which a lost goodbye is said once more.
    void leave(std::function<void()> left);
    /// Moves by itself.
    void carry_out(const romano_command& command) { body_.carry_out(command); }

    [[nodiscard]] const RobotCounters& counters() const { return counters_; }
    [[nodiscard]] const RobotCore& core() const { return robot_; }
    [[nodiscard]] const Body& body() const { return body_; }

private:
    void wait_for_datagrams(boost::asio::posix::stream_descriptor& socket);
    void run();
    void carry_out_commands();
    void publish_telemetry();
    void publish_of_loop(const message::RomanoId& to, Bytes octets, mqttsn::Qos qos);
    [[nodiscard]] std::string where() const;

    void copy_path(const Pose& ahead);

    void on_established() override;
    void on_publish_request(std::string_view topic, Bytes kind_of_data) override;
    void on_message(std::string_view topic, Bytes octets) override;

    SimulatedRobotOptions options_;
    Say say_;
    romano_udp_board udp_{};
    std::optional<RadioBoard> radio_;
    std::optional<KeyedBoard> keyed_;  // of the robot with a key
    boost::asio::posix::stream_descriptor socket_;
    boost::asio::posix::stream_descriptor cell_;
    net::CoreTimer timer_;
    Robot<> robot_;
    Body body_;
    SimulatedLoops loops_;
    RobotCounters counters_;
    Instant telemetry_at_ = never;
    std::function<void()> left_;    // empty: it stays
    Instant leaves_at_ = never;     // at the latest
    std::optional<Pose> followed_;  // where the one ahead was last
};

}  // namespace romano::firmware
