// One datagram for many robots (romano/mqttsn/cell.md), between real processes.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "romano/message/codec.h"
#include "tests/system/broker_fixture.h"
#include "tests/system/metrics_page.h"
#include "tests/system/test_client.h"

namespace romano::system::cell_test {
namespace {

using testing::HasSubstr;

std::string normal_data(std::string_view text) {
    std::array<std::uint8_t, message::max_message> room{};
    const std::size_t size = message::encode(message::NormalData{as_octets(text)}, room);
    return std::string{as_text(Bytes{room}.first(size))};
}

struct CellOfRobots : BrokerFixture {
    std::vector<std::string> broker_options(int metrics) {
        return {"--cell-group", group, "--metrics", addresses.service(metrics)};
    }
    Process& start_robot(const std::string& id, std::vector<std::string> more) {
        std::vector<std::string> arguments{"--id", id, "--broker", addresses.service(1)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        robots.push_back(std::make_unique<Process>(ROMANO_ROBOT, arguments));
        return *robots.back();
    }
    void start_robots() {
        for (const char* id : {"00000001", "00000002", "00000003"}) {
            start_robot(id, {"--cell-group", group});
        }
        start_robot("00000004", {});  // as robots ever were
        for (const auto& robot : robots) ASSERT_NE(robot->wait_for("established"), "");
    }
    void all_hear(const std::string& text) {
        for (const auto& robot : robots) {
            EXPECT_THAT(robot->wait_for("hears"), HasSubstr("`" + text + "` on `common`"));
        }
    }
    bool says(int metrics, const std::string& series, double at_least, double at_most = 1e9) {
        return metrics_come_to_say(addresses.service_endpoint(metrics), series, at_least, at_most);
    }

    std::string group = "239.18.83.1:" + std::to_string(19'000 + addresses.domain());
    std::vector<std::unique_ptr<Process>> robots;
};

TEST_F(CellOfRobots, HearsOneDatagramAndUnmodifiedClientsBesideItUnicasts) {
    start_broker(1, broker_options(2));
    start_robots();
    TestClient unmodified(addresses.client(), addresses.service_endpoint(1), "monitor");
    ASSERT_TRUE(unmodified.connect());
    ASSERT_TRUE(unmodified.subscribe("common", mqttsn::Qos::at_least_once));
    TestClient publisher(addresses.client(), addresses.service_endpoint(1), "publisher");
    ASSERT_TRUE(publisher.connect());
    ASSERT_TRUE(says(2, "romano_subscriptions", 4 * 2 + 3 + 1));
    const auto common = publisher.register_topic("common");
    ASSERT_TRUE(common);
    const auto all_get = [&](const std::string& text, mqttsn::Qos qos) {
        ASSERT_TRUE(publisher.publish(*common, normal_data(text), qos));
        all_hear(text);
        EXPECT_TRUE(unmodified.run_until([&] {
            return !unmodified.received.empty() &&
                   unmodified.received.back().data == normal_data(text);
        }));
        EXPECT_TRUE(says(2, "romano_queued_messages", 0, 0)) << "all have answered";
    };

    all_get("zero", mqttsn::Qos::at_most_once);
    EXPECT_TRUE(says(2, "romano_cell_publishes_total", 1, 1));
    EXPECT_TRUE(says(2, "romano_cell_deliveries_total", 3, 3));
    all_get("one", mqttsn::Qos::at_least_once);
    EXPECT_TRUE(says(2, "romano_cell_publishes_total", 2, 2));
    all_get("two", mqttsn::Qos::exactly_once);
    EXPECT_TRUE(says(2, "romano_cell_publishes_total", 2, 2)) << "QoS 2 stays unicast";
}

TEST_F(CellOfRobots, IsWhereARobotThatIsTheBrokerListensToo) {
    Process carrier(ROMANO_BROKER_ROBOT,
                    {"--id", "0000000a", "--listen", addresses.service(1), "--cell-group", group,
                     "--metrics", addresses.service(2)});
    ASSERT_NE(carrier.wait_for("0000000a established"), "");
    Process& guest = start_robot("00000001", {"--cell-group", group});
    ASSERT_NE(guest.wait_for("established"), "");
    TestClient publisher(addresses.client(), addresses.service_endpoint(1), "publisher");
    ASSERT_TRUE(publisher.connect());
    ASSERT_TRUE(says(2, "romano_subscriptions", 2 * 3));
    const auto common = publisher.register_topic("common");
    ASSERT_TRUE(common);
    ASSERT_TRUE(publisher.publish(*common, normal_data("both"), mqttsn::Qos::at_least_once));
    EXPECT_NE(carrier.wait_for("`both` on `common`"), "");
    EXPECT_NE(guest.wait_for("`both` on `common`"), "");
    EXPECT_TRUE(says(2, "romano_cell_deliveries_total", 2, 2));
    EXPECT_TRUE(says(2, "romano_queued_messages", 0, 0)) << "both have answered";
}

struct BadGroup {
    std::string name;
    std::vector<std::string> options;
};
class RobotWithABadCellGroup : public testing::TestWithParam<BadGroup> {};

TEST_P(RobotWithABadCellGroup, SaysOneSentence) {
    Process robot(ROMANO_ROBOT, GetParam().options);
    EXPECT_EQ(robot.wait_for_exit(), 2);
    EXPECT_THAT(robot.errors(), HasSubstr("--cell-group '"));
}

INSTANTIATE_TEST_SUITE_P(
    Each, RobotWithABadCellGroup,
    testing::Values(
        BadGroup{"NoMulticast", {"--broker", "127.0.0.1:1", "--cell-group", "127.0.0.1:1884"}},
        BadGroup{"NoPort", {"--broker", "127.0.0.1:1", "--cell-group", "239.1.2.3"}},
        BadGroup{"OtherFamily", {"--broker", "127.0.0.1:1", "--cell-group", "[ff05::1]:1884"}},
        BadGroup{"WithAKey",
                 {"--broker", "127.0.0.1:1", "--key", "/", "--cell-group", "239.1.2.3:1884"}}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace romano::system::cell_test
