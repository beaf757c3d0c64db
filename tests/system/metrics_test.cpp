// What real brokers tell Prometheus, and say in their trace.

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

#include "tests/system/broker_process.h"
#include "tests/system/metrics_page.h"
#include "tests/system/test_addresses.h"
#include "tests/system/test_client.h"

namespace romano::system::metrics_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::HasSubstr;
using testing::Not;

/// The page is made anew ten times a second: waits until it says so.
bool comes_to_say(const Endpoint& address, const std::string& line) {
    const auto deadline = std::chrono::steady_clock::now() + 30s;
    while (std::chrono::steady_clock::now() < deadline) {
        if (metrics_page_at(address).find(line) != std::string::npos) return true;
        std::this_thread::sleep_for(20ms);
    }
    return false;
}

struct Metrics : testing::Test {
    [[nodiscard]] std::vector<std::string> arguments(int n) const {
        return {"--listen",  addresses.service(n), "--name", "r" + std::to_string(n),
                "--metrics", addresses.service(n)};
    }
    [[nodiscard]] Endpoint at(int n) const { return addresses.service_endpoint(n); }

    TestAddresses addresses;
};

TEST_F(Metrics, TellOfTheMemoryInUseAndItsLimitIsKept) {
    auto with_little = arguments(1);
    with_little.insert(with_little.end(), {"--max-memory-mb", "8"});
    BrokerProcess broker(with_little);
    broker.wait_until_serving();
    TestClient client(addresses.client(), at(1), "c");
    ASSERT_TRUE(client.connect());
    const auto retains = [&](int n, const std::string& data) {
        const auto topic = client.register_topic("map/" + std::to_string(n % 10));
        return topic && client.publish(*topic, data, Qos::at_least_once, true);
    };
    ASSERT_TRUE(retains(0, "x"));
    // Sleepers' queues and retained messages: 60,000 octets each until no more are taken.
    TestClient sleeper(addresses.client(), at(1), "sleeper");
    ASSERT_TRUE(sleeper.connect(false));
    ASSERT_TRUE(sleeper.subscribe("map/#", Qos::at_least_once));
    ASSERT_TRUE(sleeper.disconnect());
    int taken = 0;
    while (taken < 200 && retains(taken % 10, std::string(60'000, 'x'))) ++taken;
    EXPECT_GT(taken, 50);
    EXPECT_LT(taken, 140) << "8 MiB";
    EXPECT_TRUE(comes_to_say(at(1), "romano_drops_total{reason=\"no_room\"} 1"));
    EXPECT_THAT(metrics_page_at(at(1)), HasSubstr("romano_heap_limit_octets 8388608"));
    EXPECT_THAT(metrics_page_at(at(1)), HasSubstr("romano_heap_octets 8"));
    // What is taken away makes room.
    ASSERT_TRUE(sleeper.connect(true));
    EXPECT_TRUE(retains(0, "x"));
}

TEST_F(Metrics, CountWhatALoneBrokerDoes) {
    BrokerProcess broker(arguments(1));
    broker.wait_until_serving();
    TestClient client(addresses.client(), at(1), "c");
    ASSERT_TRUE(client.connect());
    ASSERT_TRUE(client.subscribe("pose", Qos::at_least_once));
    const auto topic = client.register_topic("pose");
    ASSERT_TRUE(topic);
    ASSERT_TRUE(client.publish(*topic, "x", Qos::at_least_once, true));
    ASSERT_TRUE(client.run_until([&] { return !client.received.empty(); }));
    EXPECT_TRUE(comes_to_say(at(1), "romano_messages_received_total{type=\"CONNECT\"} 1\n"));
    const std::string page = metrics_page_at(at(1));
    EXPECT_THAT(page, HasSubstr("romano_broker_info{name=\"r1\",version=\""));
    EXPECT_THAT(page, HasSubstr("romano_sessions{state=\"active\"} 1\n"));
    EXPECT_THAT(page, HasSubstr("romano_publishes_received_total 1\n"));
    EXPECT_THAT(page, HasSubstr("romano_subscriptions 1\n"));
    EXPECT_THAT(page, HasSubstr("romano_datagram_handling_seconds_count "));
    EXPECT_THAT(page, HasSubstr("romano_wakeup_delay_seconds_count "));
    EXPECT_THAT(page, HasSubstr("romano_longest_turn_seconds "));
    EXPECT_THAT(page, Not(HasSubstr("romano_longest_turn_seconds 0\n")));
    EXPECT_THAT(page, Not(HasSubstr("romano_cluster_")));
}

TEST_F(Metrics, TellOfViewAndTakeOverInACluster) {
    const std::vector<std::string> cluster = {"--domain", std::to_string(addresses.domain()),
                                              "--interface", "lo"};
    const auto start = [&](int n) {
        auto words = arguments(n);
        words.insert(words.end(), cluster.begin(), cluster.end());
        return std::make_unique<BrokerProcess>(words);
    };
    auto first = start(1);
    auto second = start(2);
    first->wait_until_serving();
    second->wait_until_serving();
    EXPECT_TRUE(comes_to_say(at(1), "romano_cluster_view_members 2\n"));
    EXPECT_TRUE(comes_to_say(at(1), "romano_cluster_condition 100\n"));
    EXPECT_TRUE(comes_to_say(at(1), "romano_cluster_peer_alive{peer=\"r2\"} 1\n"));
    TestClient client(addresses.client(), at(2), "c");
    ASSERT_TRUE(client.connect());
    second->kill_9();
    EXPECT_TRUE(comes_to_say(at(1), "romano_cluster_take_overs_total 1\n"));
    EXPECT_TRUE(comes_to_say(at(1), "romano_cluster_leader_info{name=\"r1\"} 1\n"));
    EXPECT_TRUE(comes_to_say(at(1), "romano_cluster_log_unacknowledged_events 0\n"));
}

TEST_F(Metrics, ABadSenderIsNamedOnceAndCounted) {
    BrokerProcess broker(arguments(1));
    broker.wait_until_serving();
    const auto to = net::to_socket_address(at(1));
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    for (int i = 0; i < 5; ++i) sendto(socket, "GET / HTTP", 10, 0, &to.any, to.size);
    close(socket);
    EXPECT_TRUE(comes_to_say(at(1), "romano_malformed_datagrams_total{reason=\"length\"} 5\n"));
    const std::string trace = broker.errors();
    EXPECT_THAT(trace, HasSubstr("10 octets that are no MQTT-SN: 47 45 54"));
    EXPECT_EQ(trace.find("no MQTT-SN"), trace.rfind("no MQTT-SN")) << trace;
}

TEST_F(Metrics, OnAPortThatIsInUseAreRefused) {
    BrokerProcess first(arguments(1));
    first.wait_until_serving();
    BrokerProcess second({"--listen", addresses.service(2), "--metrics", addresses.service(1)});
    EXPECT_EQ(second.wait_for_exit(), 2);
    EXPECT_THAT(second.errors(), HasSubstr("--metrics '" + addresses.service(1) + "': cannot"));
    EXPECT_EQ(second.next_line(), "");
}

TEST_F(Metrics, ALoneBrokerHasNoDdsInItsMemory) {
    BrokerProcess broker(arguments(1));
    broker.wait_until_serving();
    std::ifstream maps("/proc/" + std::to_string(broker.pid()) + "/maps");
    const std::string mapped{std::istreambuf_iterator<char>(maps), {}};
    EXPECT_THAT(mapped, HasSubstr("libc"));
    EXPECT_THAT(mapped, Not(HasSubstr("libddsc")));
    EXPECT_THAT(mapped, Not(HasSubstr("libprotobuf")));
}

}  // namespace
}  // namespace romano::system::metrics_test
