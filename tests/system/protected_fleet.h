// Brokers at protected addresses, alone or in a cluster, and a fleet with keys of `romano keys`:
// two robots, and anna.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "romano/keys/key_folder.h"
#include "tests/system/broker_fixture.h"
#include "tests/system/metrics_page.h"
#include "tests/system/test_client.h"
#include "tests/temporary_folder.h"

namespace romano::system {

struct ProtectedFleet : BrokerFixture {
    ProtectedFleet() {
        EXPECT_EQ(romano({"keys", "new", fleet.string(), "--broker", "r1", "--broker", "r2",
                          "--robot", "abcd1234", "--robot", "00000007", "--operator", "anna"}),
                  0)
            << said;
    }
    int romano(const std::vector<std::string>& arguments) {
        Process program(ROMANO_PROGRAM, arguments);
        said = program.rest_of_output();
        const int code = program.wait_for_exit();
        said += program.errors();
        return code;
    }
    int romano_at(int broker, std::vector<std::string> arguments) {
        const std::string service = addresses.service(broker);
        const auto colon = service.find(':');
        arguments.insert(arguments.begin() + 1,
                         {"-h", service.substr(0, colon), "-p", service.substr(colon + 1)});
        return romano(arguments);
    }
    BrokerProcess& start_protected(int n, const std::vector<std::string>& more = {}) {
        const std::string name = "r" + std::to_string(n);
        std::vector<std::string> arguments{
            "--listen", scheme + addresses.service(n), "--name",    name,
            "--keys",   keys.broker_folder(name),      "--metrics", addresses.service(n)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        brokers.push_back(std::make_unique<BrokerProcess>(arguments));
        brokers.back()->wait_until_serving();
        return *brokers.back();
    }
    std::unique_ptr<TestClient> client_of(int broker, const std::string& name) {
        const auto file =
            keys.own_file(name, name == "anna" ? keys::Role::person : keys::Role::robot);
        return std::make_unique<TestClient>(addresses.client(), addresses.service_endpoint(broker),
                                            KeyFile{file});
    }
    struct RobotAndAnna {
        std::unique_ptr<TestClient> robot;
        std::unique_ptr<TestClient> anna;
        mqttsn::TopicId topic{};  // that anna publishes under
    };
    /// abcd1234, at the first broker, hears what anna publishes at the second.
    RobotAndAnna robot_that_hears_anna(mqttsn::Qos qos) {
        RobotAndAnna both{client_of(1, "abcd1234"), client_of(2, "anna")};
        const std::string pose = "robots/abcd1234/pose";
        EXPECT_TRUE(both.robot->connect());
        EXPECT_TRUE(both.robot->subscribe(pose, qos));
        EXPECT_TRUE(both.anna->connect());
        const auto topic = both.anna->register_topic(pose);
        EXPECT_TRUE(topic);
        both.topic = topic.value_or(mqttsn::TopicId{});
        return both;
    }
    bool counts(int broker, const std::string& reason, int at_least) {
        return metrics_come_to_say(addresses.service_endpoint(broker),
                                   "romano_protection_refusals_total{reason=\"" + reason + "\"}",
                                   at_least);
    }

    void start_member(int n, const std::vector<std::string>& more = {}) {
        std::vector<std::string> arguments{
            "--domain",        std::to_string(addresses.domain()), "--interface", "lo", "--rank",
            std::to_string(n), "--detection-timeout-ms",           "300"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        start_protected(n, arguments);
    }
    void expect_both_in_view() {
        for (int n = 1; n <= 2; ++n) {
            ASSERT_TRUE(metrics_come_to_say(addresses.service_endpoint(n),
                                            "romano_cluster_view_members", 2));
        }
    }
    void start_both() {
        start_member(1);
        start_member(2);
        expect_both_in_view();
    }

    std::string scheme = "protected://";
    tests::TemporaryFolder folder;
    std::filesystem::path fleet = folder / "fleet";
    keys::KeyFolder keys{fleet};
    std::string said;
};

}  // namespace romano::system
