#include "firmware/robot/romano.h"

#include <algorithm>
#include <array>
#include <new>

#include "firmware/robot/address.h"
#include "firmware/robot/robot.h"
#include "romano/message/codec.h"

namespace {

using namespace romano;
using namespace std::chrono_literals;

/// Hands what a robot is told to functions in C.
class ControllerInC final : public firmware::Controller {
public:
    explicit ControllerInC(const romano_controller* functions)
        : functions_(functions != nullptr ? *functions : romano_controller{}) {}

    void on_established() override {
        if (functions_.on_established != nullptr) functions_.on_established(functions_.self);
    }
    void on_publish_request(std::string_view topic, Bytes kind) override {
        if (functions_.on_publish_request == nullptr) return;
        functions_.on_publish_request(functions_.self, topic.data(), size(topic), kind.data(),
                                      size(kind));
    }
    void on_message(std::string_view topic, Bytes message) override {
        if (functions_.on_message == nullptr) return;
        functions_.on_message(functions_.self, topic.data(), size(topic), message.data(),
                              size(message));
    }

private:
    template <typename Range>
    static std::uint32_t size(const Range& range) {
        return static_cast<std::uint32_t>(range.size());
    }
    romano_controller functions_;
};

struct RobotForC {
    RobotForC(const firmware::RobotSettings& settings, const romano_board& board,
              const romano_controller* functions)
        : controller(functions), robot(settings, board, controller) {}
    ControllerInC controller;
    firmware::Robot<> robot;
};
static_assert(sizeof(RobotForC) <= sizeof(romano_robot));
static_assert(alignof(RobotForC) <= alignof(romano_robot));

RobotForC& robot_of(romano_robot* robot) {
    return *std::launder(reinterpret_cast<RobotForC*>(robot->storage));
}

}  // namespace

void romano_id_of(const std::uint8_t ipv6[16], char id[9]) {
    const auto made = message::RomanoId::from_ipv6(std::span<const std::uint8_t, 16>{ipv6, 16});
    std::ranges::copy(made.text(), id);
    id[8] = '\0';
}

bool romano_start(romano_robot* robot, const romano_settings* settings, const romano_board* board,
                  const romano_controller* controller) {
    const auto id = message::RomanoId::parse(settings->id);
    if (!id) return false;
    firmware::RobotSettings out;
    out.node.id = *id;
    if (settings->keep_alive_s != 0) {
        out.node.keep_alive = std::chrono::seconds{settings->keep_alive_s};
    }
    out.node.heartbeat_every = std::chrono::seconds{settings->heartbeat_s};
    out.node.keep_session = settings->keep_session;
    out.node.listens_to_cell = settings->listens_to_cell;
    out.broker = firmware::endpoint_of(settings->broker);
    out.seed = settings->seed;
    new (robot->storage) RobotForC(out, *board, controller);
    return true;
}

std::uint32_t romano_run(romano_robot* robot) {
    firmware::RobotCore& core = robot_of(robot).robot;
    const Instant now = core.now();
    const Instant due = std::min(core.run(), now + 10s);
    if (due <= now) return 0;
    return static_cast<std::uint32_t>(
        std::chrono::ceil<std::chrono::milliseconds>(due - now).count());
}

bool romano_next_command(romano_robot* robot, romano_command* command) {
    return robot_of(robot).robot.next_command(*command);
}

bool romano_publish(romano_robot* robot, const char* topic, std::uint8_t type,
                    const std::uint8_t* data, std::uint32_t size, int qos) {
    std::array<std::uint8_t, message::max_message> octets{type};
    if (size > octets.size() - 2 || qos < 0 || qos > 2) return false;
    octets[1] = static_cast<std::uint8_t>(size + 2);
    std::copy(data, data + size, octets.begin() + 2);
    const auto message = message::decode(Bytes{octets}.first(size + 2));
    return message && robot_of(robot).robot.publish(topic, *message, static_cast<mqttsn::Qos>(qos));
}

bool romano_subscribe(romano_robot* robot, const char* topic) {
    return robot_of(robot).robot.subscribe(topic);
}

void romano_leave(romano_robot* robot) {
    robot_of(robot).robot.leave();
}

bool romano_is_established(const romano_robot* robot) {
    return robot_of(const_cast<romano_robot*>(robot)).robot.node().phase() ==
           node::Phase::established;
}
