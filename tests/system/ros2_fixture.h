// Brokers that bridge to ROS 2, robots at them, and somebody else's programs in ROS 2's domain.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/system/broker_fixture.h"
#include "tests/system/test_client.h"
#include "tests/temporary_folder.h"

namespace romano::system::ros2 {

using namespace std::chrono_literals;
using mqttsn::Qos;

using Lines = std::vector<std::string>;

inline std::string octets(std::initializer_list<int> values) {
    std::string out;
    for (const int value : values) out += static_cast<char>(value);
    return out;
}

/// x 1000 mm, y -500 mm, heading 90 degrees.
inline const std::string location =
    octets({0x06, 16, 0, 2, 0, 0, 0x03, 0xE8, 0xFF, 0xFF, 0xFE, 0x0C, 0, 0x01, 0x5F, 0x90});
inline const std::string speed_100_mm_s = octets({0x06, 12, 0, 3, 0, 0, 0, 100, 0, 0, 0, 0});
inline const std::string battery_7500_mv = octets({0x06, 6, 0, 4, 0x1D, 0x4C});
inline const std::string proximity_450_mm = octets({0x06, 8, 0, 1, 0, 0, 0x01, 0xC2});

inline std::string movement(int type, int amount) {
    return octets({0x07, 8, 0, type, 0, 0, amount / 256, amount % 256});
}

inline constexpr const char* robots = R"(
out robots/+/telemetry /robot_+/odom     nav_msgs/msg/Odometry       frame=odom child=+
out robots/+/telemetry /robot_+/battery  sensor_msgs/msg/BatteryState full=8.5 empty=6.5
out robots/+/telemetry /robot_+/range    sensor_msgs/msg/Range       min=0.25 max=4 fov=0.5
out robots/+/raw       /robot_+/raw      std_msgs/msg/UInt8MultiArray
out robots/+/move      /robot_+/cmd_vel  geometry_msgs/msg/Twist     speed=0.25
out robots/+/text      /robot_+/text     std_msgs/msg/String
)";

/// Somebody else's program in ROS 2's domain, and what it has seen.
class RosPeer {
public:
    RosPeer(const std::string& program, const Lines& arguments) : process_(program, arguments) {}

    /// Reads on until `count` lines begin with `words`; those, or as many empty ones.
    Lines wait_for(const std::string& words, std::size_t count = 1) {
        const bool came = read_until([&] { return seen(words).size() >= count; });
        EXPECT_TRUE(came) << words << "\n" << testing::PrintToString(lines_);
        return came ? seen(words) : Lines(count);
    }
    bool read_until(const std::function<bool()>& done, std::chrono::milliseconds limit = 20s) {
        const auto deadline = std::chrono::steady_clock::now() + limit;
        while (!done() && std::chrono::steady_clock::now() < deadline) {
            std::string line = process_.next_line(100ms);
            if (!line.empty()) lines_.push_back(std::move(line));
        }
        return done();
    }
    /// Of what was read so far.
    [[nodiscard]] Lines seen(const std::string& words) const {
        Lines found;
        std::ranges::copy_if(lines_, std::back_inserter(found),
                             [&](const std::string& line) { return line.starts_with(words); });
        return found;
    }
    [[nodiscard]] Process& process() { return process_; }

private:
    Process process_;
    Lines lines_;
};

struct Ros2 : BrokerFixture {
    /// A member of the cluster that bridges by these rules.
    BrokerProcess& start(int n, const std::string& rules, Lines more = {}) {
        std::ofstream(folder / "rules") << rules;
        more.insert(more.end(), {"--ros2-domain", std::to_string(ros.id()), "--ros2-rules",
                                 (folder / "rules").string()});
        return start_member(n, std::move(more));
    }
    std::unique_ptr<RosPeer> peer(const Lines& more, const std::string& release = "iron") {
        Lines arguments{std::to_string(ros.id()), release};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return std::make_unique<RosPeer>(FAST_DDS_PEER, arguments);
    }
    std::unique_ptr<TestClient> client(const std::string& id, int broker = 1) {
        auto robot = std::make_unique<TestClient>(addresses.client(),
                                                  addresses.service_endpoint(broker), id);
        EXPECT_TRUE(robot->connect());
        return robot;
    }
    static bool wait_for_trace(Process& broker, const std::string& words) {
        const auto deadline = std::chrono::steady_clock::now() + 20s;
        while (broker.errors().find(words) == std::string::npos) {
            if (std::chrono::steady_clock::now() > deadline) return false;
            usleep(10'000);
        }
        return true;
    }
    static void publish(TestClient& robot, const std::string& topic, const std::string& data,
                        Qos qos = Qos::at_least_once, bool retain = false) {
        const auto id = robot.register_topic(topic);
        ASSERT_TRUE(id);
        ASSERT_TRUE(robot.publish(*id, data, qos, retain));
    }

    /// Again and again until the peer has heard it: each side finds the other in its own time, and
    /// what is volatile and said before is lost.
    static void publish_until(TestClient& robot, RosPeer& peer, const std::string& topic,
                              const std::string& data, const std::string& heard) {
        const auto has_heard = [&] { return !peer.seen(heard).empty(); };
        for (int tries = 0; tries < 100 && !has_heard(); ++tries) {
            publish(robot, topic, data);
            peer.read_until(has_heard, 200ms);
        }
        EXPECT_TRUE(has_heard()) << heard;
    }

    [[nodiscard]] std::string metrics() const {
        return "127.77." + std::to_string(addresses.domain()) + ".1:19830";
    }

    dds::TestDomain ros;
    tests::TemporaryFolder folder;
};

}  // namespace romano::system::ros2
