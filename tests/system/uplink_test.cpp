// The uplink through a real mosquitto, with TLS and credentials: the leader holds it, nothing is
// doubled or looped, and the death of the leader loses nothing of QoS 1 and 2.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <set>

#include "experiments/mqtt/mosquitto_server.h"
#include "experiments/mqtt/mqtt_client.h"
#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"
#include "tests/system/test_client.h"
#include "tests/temporary_folder.h"

namespace romano::system::uplink_test {
namespace {

using namespace std::chrono_literals;
using experiments::MosquittoServer;
using experiments::MqttClient;
using mqttsn::Qos;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

constexpr std::uint16_t mqtt_port = 18883;

struct Network {
    explicit Network(std::string network_name) : name(std::move(network_name)) {}

    BrokerProcess& start(int n, const MosquittoServer& server, const std::string& mqtt_address,
                         std::vector<std::string> more = {}) {
        std::vector<std::string> arguments{"--listen",
                                           addresses.service(n),
                                           "--name",
                                           name + std::to_string(n),
                                           "--domain",
                                           std::to_string(addresses.domain()),
                                           "--interface",
                                           "lo",
                                           "--rank",
                                           std::to_string(n),
                                           "--detection-timeout-ms",
                                           "300",
                                           "--uplink",
                                           server.url(mqtt_address),
                                           "--uplink-network",
                                           name,
                                           "--uplink-topic",
                                           "fleet/#",
                                           "--uplink-username",
                                           MosquittoServer::username,
                                           "--uplink-password-file",
                                           server.password_file()};
        if (server.has_tls()) {
            arguments.insert(arguments.end(), {"--uplink-ca", server.ca_file()});
        }
        arguments.insert(arguments.end(), more.begin(), more.end());
        brokers[n] = std::make_unique<BrokerProcess>(arguments);
        brokers[n]->wait_until_serving();
        return *brokers[n];
    }
    std::unique_ptr<TestClient> client(const std::string& id, int broker) {
        auto robot = std::make_unique<TestClient>(addresses.client(),
                                                  addresses.service_endpoint(broker), id);
        EXPECT_TRUE(robot->connect());
        return robot;
    }

    TestAddresses addresses;
    std::string name;
    std::map<int, std::unique_ptr<BrokerProcess>> brokers;
};

bool wait_for_trace(Process& broker, const std::string& words) {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (broker.errors().find(words) == std::string::npos) {
        if (std::chrono::steady_clock::now() > deadline) return false;
        usleep(10'000);
    }
    return true;
}

struct Uplink : testing::Test {
    std::string mqtt_address(const Network& network, int n = 250) const {
        return "127.77." + std::to_string(network.addresses.domain()) + "." + std::to_string(n);
    }
    std::unique_ptr<MosquittoServer> mosquitto(std::vector<std::string> at, bool tls = true) {
        return std::make_unique<MosquittoServer>(folder / "mosquitto", std::move(at), mqtt_port,
                                                 tls);
    }

    tests::TemporaryFolder folder;
    Network a{"site-a"};
};

TEST_F(Uplink, CarriesEveryQosBothWaysOverTlsWithAPassword) {
    const auto server = mosquitto({mqtt_address(a)});
    BrokerProcess& broker = a.start(1, *server, mqtt_address(a));
    ASSERT_TRUE(wait_for_trace(broker, "uplink: connected")) << broker.errors();
    MqttClient outside(*server, mqtt_address(a), "outside");
    outside.subscribe("fleet/up", 2);
    const auto robot = a.client("robot", 1);
    ASSERT_TRUE(robot->subscribe("fleet/down", Qos::exactly_once));
    const auto topic = robot->register_topic("fleet/up");
    ASSERT_TRUE(topic);
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
        ASSERT_TRUE(robot->publish(*topic, "up" + std::to_string(static_cast<int>(qos)), qos));
        outside.publish("fleet/down", "down" + std::to_string(static_cast<int>(qos)),
                        static_cast<int>(qos));
    }
    EXPECT_TRUE(robot->run_until([&] { return robot->received.size() >= 3; }));
    EXPECT_TRUE(outside.wait_until([&] { return outside.received().size() >= 3; }));
    std::vector<std::string> up;
    for (const auto& message : outside.received()) up.push_back(message.payload);
    EXPECT_THAT(up, ElementsAre("up0", "up1", "up2"));
    EXPECT_EQ(outside.received()[2].qos, 2);
    std::vector<std::string> down;
    for (const auto& message : robot->received) down.push_back(message.data);
    EXPECT_THAT(down, ElementsAre("down0", "down1", "down2"));
}

TEST_F(Uplink, AWrongPasswordIsSaidAndTheBrokerServesOn) {
    const auto server = mosquitto({mqtt_address(a)});
    std::ofstream(server->password_file()) << "guess\n";
    BrokerProcess& broker = a.start(1, *server, mqtt_address(a));
    EXPECT_TRUE(wait_for_trace(broker, "uplink: no connection")) << broker.errors();
    EXPECT_THAT(broker.errors(), testing::ContainsRegex("uplink: no connection.*[Nn]ot authori"));
    EXPECT_TRUE(a.client("robot", 1)->ping());
}

TEST_F(Uplink, WhatIsPublishedWhileMosquittoIsAwayArrivesInOrderOnceItIsBack) {
    const auto server = mosquitto({mqtt_address(a)}, false);
    BrokerProcess& broker = a.start(1, *server, mqtt_address(a));
    ASSERT_TRUE(wait_for_trace(broker, "uplink: connected")) << broker.errors();
    server->kill();
    const auto robot = a.client("robot", 1);
    const auto topic = robot->register_topic("fleet/up");
    for (int i = 0; i < 10; ++i) {
        ASSERT_TRUE(robot->publish(*topic, std::to_string(i), Qos::at_least_once));
    }
    server->start();
    MqttClient outside(*server, mqtt_address(a), "outside");
    outside.subscribe("fleet/#", 1);
    // It may have been back before we were there: then those went to nobody.
    for (int i = 10; i < 12; ++i) {
        ASSERT_TRUE(robot->publish(*topic, std::to_string(i), Qos::at_least_once));
    }
    ASSERT_TRUE(outside.wait_until([&] {
        const auto received = outside.received();
        return !received.empty() && received.back().payload == "11";
    }));
    const auto received = outside.received();
    for (std::size_t i = 1; i < received.size(); ++i) {
        EXPECT_EQ(std::stoi(received[i].payload), std::stoi(received[i - 1].payload) + 1);
    }
}

/// Numbered messages both ways while the leader is killed.
TEST_F(Uplink, TheLeadersDeathUnderTrafficLosesNothingAndDoublesNothing) {
    const auto server = mosquitto({mqtt_address(a)});
    for (const int n : {1, 2, 3}) a.start(n, *server, mqtt_address(a));
    MqttClient outside(*server, mqtt_address(a), "outside");
    outside.subscribe("fleet/up", 2);
    const auto robot = a.client("robot", 1);
    ASSERT_TRUE(robot->subscribe("fleet/down", Qos::exactly_once));
    const auto topic = robot->register_topic("fleet/up");
    ASSERT_TRUE(topic);
    // The leader is whoever of them says so; what comes back tells that the way is open.
    for (int tries = 0; tries < 40 && robot->received.empty(); ++tries) {
        outside.publish("fleet/down", "open", 1);
        robot->run_until([&] { return !robot->received.empty(); }, 500ms);
    }
    ASSERT_FALSE(robot->received.empty());
    constexpr int messages = 200;
    for (int i = 0; i < messages; ++i) {
        if (i == messages / 3) a.brokers[3]->kill_9();
        outside.publish("fleet/down", std::to_string(i), i % 2 == 0 ? 1 : 2);
        ASSERT_TRUE(robot->publish(*topic, std::to_string(i),
                                   i % 2 == 0 ? Qos::at_least_once : Qos::exactly_once));
    }
    const auto all_down = [&] {
        std::map<std::string, int> times;
        for (const auto& message : robot->received) {
            int& before = times[message.data];
            // Of QoS 1, its home may repeat it, and says so.
            if (!message.dup || before == 0) ++before;
        }
        times.erase("open");
        return times;
    };
    EXPECT_TRUE(robot->run_until([&] { return all_down().size() >= messages; }));
    for (const auto& [number, times] : all_down()) EXPECT_EQ(times, 1) << number;

    const auto all_up = [&] {
        std::map<std::string, std::set<std::string>> identities;
        for (const auto& message : outside.received()) {
            identities[message.payload].insert(message.identity);
        }
        return identities;
    };
    EXPECT_TRUE(outside.wait_until([&] { return all_up().size() >= messages; }));
    for (int i = 0; i < messages; ++i) EXPECT_TRUE(all_up().contains(std::to_string(i))) << i;
    // Whoever counts identities sees each once, however often it had to be sent.
    for (const auto& [number, identities] : all_up()) EXPECT_THAT(identities, SizeIs(1)) << number;
}

TEST_F(Uplink, ANewLeaderThatCannotReadTheAuthorityServesOnUntilItCan) {
    const auto server = mosquitto({mqtt_address(a)});
    a.start(1, *server, mqtt_address(a));
    ASSERT_TRUE(wait_for_trace(*a.brokers[1], "uplink: connected"));
    BrokerProcess& heir = a.start(2, *server, mqtt_address(a));
    ASSERT_TRUE(wait_for_trace(heir, " of 2, led by ")) << heir.errors();
    const bool has_changed = heir.errors().find("uplink: connected") != std::string::npos;
    BrokerProcess& next = *a.brokers[has_changed ? 1 : 2];
    const std::filesystem::path authority = server->ca_file();
    std::filesystem::rename(authority, folder / "gone");
    a.brokers[has_changed ? 2 : 1]->kill_9();
    ASSERT_TRUE(wait_for_trace(next, "cannot be used")) << next.errors();
    EXPECT_TRUE(a.client("robot", has_changed ? 1 : 2)->ping());
    const auto before = next.errors().size();
    std::filesystem::rename(folder / "gone", authority);
    ASSERT_TRUE(wait_for_trace(next, "uplink: connected")) << next.errors();
    EXPECT_EQ(next.errors().find("cannot be used", before), std::string::npos) << next.errors();
}

TEST_F(Uplink, TwoNetworksOnIpv6AndIpv4HearEachOtherOnceAndNothingComesBack) {
    Network b{"site-b"};
    const auto server = mosquitto({mqtt_address(a), "::1"});
    BrokerProcess& first = a.start(1, *server, mqtt_address(a));
    BrokerProcess& second = b.start(1, *server, "::1");
    ASSERT_TRUE(wait_for_trace(first, "uplink: connected")) << first.errors();
    ASSERT_TRUE(wait_for_trace(second, "uplink: connected")) << second.errors();
    const auto here = a.client("here", 1);
    const auto there = b.client("there", 1);
    for (TestClient* robot : {here.get(), there.get()}) {
        ASSERT_TRUE(robot->subscribe("fleet/#", Qos::exactly_once));
    }
    const auto topic = here->register_topic("fleet/x");
    for (const Qos qos : {Qos::at_most_once, Qos::at_least_once, Qos::exactly_once}) {
        ASSERT_TRUE(here->publish(*topic, std::to_string(static_cast<int>(qos)), qos));
    }
    ASSERT_TRUE(there->run_until([&] { return there->received.size() >= 3; }));
    // A message the other way comes after whatever would have come back.
    const auto back = there->register_topic("fleet/y");
    ASSERT_TRUE(there->publish(*back, "done", Qos::exactly_once));
    ASSERT_TRUE(here->run_until(
        [&] { return !here->received.empty() && here->received.back().data == "done"; }));
    EXPECT_THAT(here->received, SizeIs(4)) << "its own three, and one from there";
    ASSERT_TRUE(there->run_until([&] { return there->received.size() >= 4; }));
    EXPECT_THAT(there->received, SizeIs(4));
    EXPECT_EQ(there->received[2].qos, Qos::exactly_once);
}

TEST(UplinkSettings, ThatAreNotPossibleAreOneSentence) {
    const auto refusal = [](std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), {"--listen", "127.77.0.1:0"});
        BrokerProcess broker(arguments);
        EXPECT_EQ(broker.wait_for_exit(), 2);
        EXPECT_EQ(std::ranges::count(broker.errors(), '\n'), 1) << broker.errors();
        return broker.errors();
    };
    const std::vector<std::string> good{"--domain",         "7",
                                        "--interface",      "lo",
                                        "--uplink-network", "x",
                                        "--uplink-topic",   "a/#",
                                        "--uplink",         "mqtt://127.0.0.1:1"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), good.begin(), good.end());
        return refusal(more);
    };
    EXPECT_THAT(refusal({"--uplink", "mqtt://h"}), HasSubstr("--domain"));
    EXPECT_THAT(refusal({"--domain", "7", "--uplink", "mqtt://h"}), HasSubstr("--uplink-network"));
    EXPECT_THAT(refusal({"--domain", "7", "--uplink", "mqtt://h", "--uplink-network", "x"}),
                HasSubstr("--uplink-topic"));
    EXPECT_THAT(refusal({"--domain", "7", "--uplink", "http://h"}), HasSubstr("'http://h'"));
    EXPECT_THAT(refusal({"--domain", "7", "--uplink", "mqtt://h:x"}), HasSubstr("'mqtt://h:x'"));
    EXPECT_THAT(refusal({"--uplink-topic", "a"}), HasSubstr("--uplink-topic needs --uplink"));
    EXPECT_THAT(with({"--uplink-topic", "b sideways"}), HasSubstr("'b sideways'"));
    EXPECT_THAT(with({"--uplink-ca", "/no/such"}), HasSubstr("'/no/such'"));
    EXPECT_THAT(with({"--uplink-password-file", "/no/such"}), HasSubstr("--uplink-username"));
    EXPECT_THAT(with({"--uplink-username", "u", "--uplink-password-file", "/no/such"}),
                HasSubstr("'/no/such'"));
}

}  // namespace
}  // namespace romano::system::uplink_test
