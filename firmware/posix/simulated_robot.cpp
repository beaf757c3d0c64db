#include "firmware/posix/simulated_robot.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "broker/net/clock.h"
#include "romano/mqttsn/topic.h"

namespace romano::firmware {
namespace {

struct Boards {
    romano_udp_board& udp;
    std::optional<RadioBoard>& radio;
    std::optional<KeyedBoard>& keyed;
};

/// Each in front of the one before.
const romano_board& open_boards(const Boards& to, const SimulatedRobotOptions& options) {
    romano_udp_board& udp = to.udp;
    romano_address local = options.local;
    if (local.family == 0) {
        local.family = options.robot.broker.family == Endpoint::Family::ipv6 ? 6 : 4;
    }
    if (const int error = romano_udp_open(&udp, &local)) {
        throw std::runtime_error("cannot open a socket for robot " +
                                 std::string{options.robot.node.id.text()} + ": " +
                                 std::strerror(error));
    }
    if (options.group.family != 0) udp.group = options.group;
    if (options.cell_group.family != 0) {
        if (const int error = romano_udp_listen(&udp, &local, &options.cell_group)) {
            const std::string why = std::strerror(error);
            romano_udp_close(&udp);
            throw std::runtime_error("--cell-group: the group cannot be joined (" + why +
                                     "); is --local an address of this machine?");
        }
    }
    const romano_board* board = &udp.board;
    if (options.radio != nullptr) board = &to.radio.emplace(*board, *options.radio).board();
    if (options.key_file.empty()) return *board;
    auto key = std::make_shared<keys::ClientPackets>(
        options.key_file, std::string{options.robot.node.id.text()}, options.speech);
    return to.keyed.emplace(*board, std::move(key)).board();
}

[[noreturn]] void refuse(const char* option, const std::string& value, const char* what) {
    throw std::invalid_argument(std::string{option} + " '" + value + "': must be " + what);
}

/// What came from the network, for a terminal and one line: other than printable ASCII as \x1b.
std::string quoted(std::string_view text) {
    std::string out = "`";
    for (const char letter : text) {
        if (letter >= ' ' && letter <= '~') {
            out += letter;
        } else {
            char digits[5];
            std::snprintf(digits, sizeof digits, "\\x%02x", static_cast<unsigned char>(letter));
            out += digits;
        }
    }
    return out + '`';
}
std::string quoted(Bytes octets) {
    return quoted(as_text(octets));
}

/// What a robot prints of a message that it does not carry out.
struct Words {
    std::string operator()(const message::NormalData& m) const { return quoted(m.data); }
    std::string operator()(const message::RemoteControl& m) const {
        return "the key " + quoted(m.data);
    }
    std::string operator()(const message::Heartbeat& m) const {
        return "the heartbeat of " + std::string{m.sender.text()};
    }
    std::string operator()(const message::ConnectedNodes& m) const {
        std::string text = std::to_string(m.count()) + " connected nodes:";
        for (std::size_t i = 0; i < m.count(); ++i) text += ' ' + std::string{m.at(i).text()};
        return text;
    }
    std::string operator()(const message::SensorData& m) const {
        return "sensor data of type " + std::to_string(static_cast<unsigned>(m.type));
    }
    std::string operator()(const message::ApplicationData& m) const {
        return "a message of type " + std::to_string(unsigned{m.type});
    }
    template <typename Other>
    std::string operator()(const Other&) const {
        return "a message";
    }
};

}  // namespace

void check_topics(const SimulatedRobotOptions& options) {
    if (!options.telemetry_topic.empty() && !mqttsn::is_valid_topic_name(options.telemetry_topic)) {
        refuse("--telemetry", options.telemetry_topic,
               "a topic's name: UTF-8, not empty, without + and #");
    }
    constexpr const char* filter =
        "UTF-8 and not empty, with + as a whole level and # as the last one";
    for (const std::string& topic : options.subscriptions) {
        if (!mqttsn::is_valid_topic_filter(topic)) refuse("--subscribe", topic, filter);
    }
    if (!options.follow.empty() && !mqttsn::is_valid_topic_filter(options.follow)) {
        refuse("--follow", options.follow, filter);
    }
}

SimulatedRobot::SimulatedRobot(boost::asio::io_context& io, const SimulatedRobotOptions& options,
                               Say say)
    : options_(options),
      say_(std::move(say)),
      socket_(io),
      cell_(io),
      timer_(io, [this] { run(); }),
      robot_(options.robot, open_boards({udp_, radio_, keyed_}, options), *this),
      body_(options.start),
      loops_(
          options.robot.node.id, options.robot.seed, body_,
          [this](const auto& to, Bytes octets, mqttsn::Qos qos) {
              publish_of_loop(to, octets, qos);
          },
          [this](const std::string& what) { say_(options_.robot.node.id, what); }) {
    socket_.assign(udp_.socket);
    wait_for_datagrams(socket_);
    if (udp_.cell >= 0) {
        cell_.assign(udp_.cell);
        wait_for_datagrams(cell_);
    }
    run();
}

SimulatedRobot::~SimulatedRobot() {
    socket_.release();
    if (udp_.cell >= 0) cell_.release();
    keyed_.reset();  // may say goodbye
    romano_udp_close(&udp_);
}

void SimulatedRobot::wait_for_datagrams(boost::asio::posix::stream_descriptor& socket) {
    socket.async_wait(boost::asio::posix::stream_descriptor::wait_read,
                      [this, &socket](const boost::system::error_code& stopped) {
                          if (stopped) return;
                          run();
                          wait_for_datagrams(socket);
                      });
}

void SimulatedRobot::run() {
    Instant next = robot_.run();
    carry_out_commands();
    if (!left_ && loops_.run(net::now())) next = robot_.run();
    if (telemetry_at_ <= robot_.now()) {
        telemetry_at_ = robot_.now() + options_.telemetry_every;
        publish_telemetry();
        next = robot_.run();
    }
    if (left_ && (robot_.has_left() || leaves_at_ <= robot_.now())) {
        leaves_at_ = never;
        std::exchange(left_, nullptr)();
    }
    const Instant loops_next = left_ ? never : loops_.next_wakeup();
    const auto due = keyed_ ? keyed_->due_in() : std::nullopt;
    const Instant keyed_next = due ? robot_.now() + *due : never;
    timer_.arm(std::min({next, telemetry_at_, leaves_at_, loops_next, keyed_next}));
}

void SimulatedRobot::leave(std::function<void()> left) {
    left_ = std::move(left);
    leaves_at_ = robot_.now() + std::chrono::milliseconds{1500};
    telemetry_at_ = never;
    robot_.leave();
    run();
}

bool SimulatedRobot::publish(std::string_view topic, const message::Message& message,
                             mqttsn::Qos qos) {
    const bool taken = robot_.publish(topic, message, qos);
    run();
    return taken;
}

void SimulatedRobot::publish_of_loop(const message::RomanoId& to, Bytes octets, mqttsn::Qos qos) {
    constexpr std::size_t header = 2;
    (void)robot_.publish(to.text(),
                         message::ApplicationData{control::data_type, octets.subspan(header)}, qos);
}

void SimulatedRobot::carry_out_commands() {
    loops_.move_on(net::now());
    for (romano_command command; robot_.next_command(command);) {
        ++counters_.commands;
        body_.carry_out(command);
        say_(options_.robot.node.id, to_text(command) + " (" + where() + ")");
    }
}

std::string SimulatedRobot::where() const {
    const Pose& pose = body_.pose();
    const auto rounded = [](double value) { return std::to_string(std::lround(value)); };
    return "x " + rounded(pose.x_mm) + " mm, y " + rounded(pose.y_mm) + " mm, heading " +
           rounded(pose.heading_deg) + " deg";
}

void SimulatedRobot::publish_telemetry() {
    loops_.move_on(net::now());
    const auto location = body_.location();
    if (robot_.publish(options_.telemetry_topic,
                       message::SensorData{message::SensorType::location, location},
                       mqttsn::Qos::at_most_once)) {
        ++counters_.telemetry;
    }
}

void SimulatedRobot::on_established() {
    ++counters_.established;
    say_(options_.robot.node.id, "established");
    for (const std::string& topic : options_.subscriptions) robot_.subscribe(topic);
    if (!options_.follow.empty()) robot_.subscribe(options_.follow);
    if (!options_.telemetry_topic.empty()) telemetry_at_ = robot_.now();
}

/// Where it is, if that is asked for; what it has no sensor for it publishes as it stands, as the
/// authors' firmware does.
void SimulatedRobot::on_publish_request(std::string_view topic, Bytes kind_of_data) {
    say_(options_.robot.node.id,
         "is asked to publish " + quoted(kind_of_data) + " on " + quoted(topic));
    loops_.move_on(net::now());
    const auto location = body_.location();
    if (as_text(kind_of_data) == "location") {
        robot_.publish(topic, message::SensorData{message::SensorType::location, location},
                       mqttsn::Qos::at_least_once);
    } else {
        robot_.publish(topic, message::NormalData{kind_of_data}, mqttsn::Qos::at_least_once);
    }
}

void SimulatedRobot::copy_path(const Pose& ahead) {
    if (followed_) body_.copy(*followed_, ahead);
    followed_ = ahead;
}

void SimulatedRobot::on_message(std::string_view topic, Bytes octets) {
    if (control::is_of_a_loop(octets)) {
        if (topic == options_.robot.node.id.text()) loops_.on_message(net::now(), octets);
        return;
    }
    const auto decoded = message::decode(octets);
    if (!decoded) return;
    const message::Message& message = *decoded;
    ++counters_.messages;
    const auto* sensor = std::get_if<message::SensorData>(&message);
    if (sensor != nullptr && topic == options_.follow) {
        if (const auto ahead = pose_of(sensor->value)) return copy_path(*ahead);
    }
    if (options_.hears && options_.hears(topic, message)) return;
    say_(options_.robot.node.id, "hears " + std::visit(Words{}, message) + " on " + quoted(topic));
}

}  // namespace romano::firmware
