// Brokers on machines of their own: a service address moves from one machine to another, and the
// client's neighbour table follows.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <netinet/if_ether.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <csignal>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <thread>

#include "broker/net/endpoint_text.h"
#include "broker/net/machine_address.h"
#include "broker/net/moved_addresses.h"
#include "broker/net/socket_address.h"
#include "experiments/process/lan.h"
#include "experiments/process/program.h"
#include "tests/system/broker_process.h"
#include "tests/system/test_client.h"

namespace romano::system::address_move_test {
namespace {

using namespace std::chrono_literals;
using experiments::Lan;
using mqttsn::Qos;

constexpr int client_host = 4;

struct Family {
    const char* name;
    const char* prefix;  // of the service address of the broker on a host: not the host's own
    const char* any;     // to bind a client
};

/// The gratuitous ARP of an address, as a machine of its network hears it.
class Announcements {
public:
    /// On the machine of the calling thread.
    explicit Announcements(const std::string& address)
        : wanted_(*net::parse_endpoint(address + ":1")),
          socket_(::socket(AF_PACKET, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, htons(ETH_P_ARP))) {}
    ~Announcements() { ::close(socket_); }
    Announcements(const Announcements&) = delete;
    Announcements& operator=(const Announcements&) = delete;

    /// Waits for the next one, for 20 s at most.
    [[nodiscard]] bool hear_one() const {
        const auto deadline = std::chrono::steady_clock::now() + 20s;
        while (std::chrono::steady_clock::now() < deadline) {
            pollfd ready{.fd = socket_, .events = POLLIN, .revents = 0};
            if (::poll(&ready, 1, 100) <= 0) continue;
            std::array<std::uint8_t, 128> frame{};
            if (::recv(socket_, frame.data(), frame.size(), 0) < ether_arp_end) continue;
            ether_arp arp{};
            std::memcpy(&arp, frame.data() + sizeof(ether_header), sizeof arp);
            const bool is_its = std::memcmp(arp.arp_spa, wanted_.address.data(), 4) == 0;
            if (is_its && std::memcmp(arp.arp_tpa, arp.arp_spa, 4) == 0) return true;
        }
        return false;
    }

private:
    static constexpr ssize_t ether_arp_end = sizeof(ether_header) + sizeof(ether_arp);

    Endpoint wanted_;
    int socket_;
};

/// A program that has a port of its machine, at all addresses of the family.
class Stranger {
public:
    /// On the machine of the calling thread.
    explicit Stranger(const Endpoint& everywhere)
        : socket_(::socket(net::to_socket_address(everywhere).any.sa_family,
                           SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        const net::SocketAddress wanted = net::to_socket_address(everywhere);
        EXPECT_EQ(::bind(socket_, &wanted.any, wanted.size), 0);
    }
    ~Stranger() { ::close(socket_); }
    Stranger(const Stranger&) = delete;
    Stranger& operator=(const Stranger&) = delete;

private:
    int socket_;
};

class AddressMove : public testing::TestWithParam<Family> {
protected:
    void SetUp() override {
        if (!lan.why_not().empty()) GTEST_SKIP() << lan.why_not();
    }
    /// Brokers and clients on IPv6 alone: neither their network nor their loopback has IPv4.
    void take_ipv4_away() const {
        for (int host = 1; host <= client_host; ++host) {
            const Lan::On on(lan, host);
            for (const char* device : {"eth0", "lo"}) {
                const auto ip =
                    experiments::run_program("ip", {"-4", "address", "flush", "dev", device});
                ASSERT_EQ(ip.exit_code, 0) << ip.output;
            }
        }
    }

    [[nodiscard]] static std::string address(int host) {
        return GetParam().prefix + std::to_string(host);
    }
    [[nodiscard]] static std::string service(int host) {
        const bool v6 = address(host).find(':') != std::string::npos;
        return (v6 ? "[" + address(host) + "]" : address(host)) + ":1883";
    }
    [[nodiscard]] std::unique_ptr<BrokerProcess> start(int host) const {
        return start(host, service(host));
    }
    /// Its name ends as its address does.
    [[nodiscard]] std::unique_ptr<BrokerProcess> start(int host, const std::string& where) const {
        const Lan::On on(lan, host);
        const std::string number{where[where.find_last_of(':') - 1 - (uses_arp() ? 0 : 1)]};
        return std::make_unique<BrokerProcess>(std::vector<std::string>{
            "--listen", where, "--allow-plain", "--name", "r" + number, "--domain", "7",
            "--interface", "eth0", "--rank", number, "--detection-timeout-ms", "500"});
    }
    [[nodiscard]] std::unique_ptr<TestClient> client_of(int host, const std::string& id) const {
        const Lan::On on(lan, client_host);
        return std::make_unique<TestClient>(*net::parse_endpoint(GetParam().any),
                                            *net::parse_endpoint(service(host)), id);
    }
    static bool eventually(const std::function<bool()>& done) {
        const auto deadline = std::chrono::steady_clock::now() + 20s;
        while (!done()) {
            if (std::chrono::steady_clock::now() > deadline) return false;
            std::this_thread::sleep_for(10ms);
        }
        return true;
    }
    /// At an address that its machine has, and without the right to add another one.
    [[nodiscard]] std::unique_ptr<Process> start_without_right(int host) const {
        const Lan::On on(lan, host);
        const std::string where =
            uses_arp() ? "10.60.0." + std::to_string(host) : "[fd60::" + std::to_string(host) + "]";
        return std::make_unique<Process>(
            "/usr/bin/setpriv",
            std::vector<std::string>{"--bounding-set=-net_admin", ROMANO_BROKER, "--allow-plain",
                                     "--listen", where + ":1883", "--name",
                                     "r" + std::to_string(host), "--domain", "7", "--interface",
                                     "eth0", "--detection-timeout-ms", "500"});
    }
    static bool is_in_view_of_all(Process& broker) {
        return eventually(
            [&] { return broker.errors().find(" of 3, led by ") != std::string::npos; });
    }
    static bool are_one_cluster(std::initializer_list<BrokerProcess*> brokers) {
        return std::ranges::all_of(brokers, [](BrokerProcess* broker) {
            broker->wait_until_serving();
            return is_in_view_of_all(*broker);
        });
    }
    [[nodiscard]] static bool uses_arp() { return address(1).find(':') == std::string::npos; }
    [[nodiscard]] int arp_announce(int host) const {
        const Lan::On on(lan, host);
        int value = -1;
        std::ifstream("/proc/sys/net/ipv4/conf/eth0/arp_announce") >> value;
        return value;
    }
    [[nodiscard]] int asks_neighbours_again_after_ms(int host) const {
        const Lan::On on(lan, host);
        const std::string family = uses_arp() ? "ipv4" : "ipv6";
        int value = -1;
        std::ifstream("/proc/sys/net/" + family + "/neigh/eth0/retrans_time_ms") >> value;
        return value;
    }
    /// Publishes until the subscriber has one of these messages.
    static bool reaches(TestClient& publisher, mqttsn::TopicId topic, TestClient& subscriber,
                        const std::string& data) {
        if (!publisher.publish(topic, data, Qos::at_least_once)) return false;
        return subscriber.run_until([&] {
            return !subscriber.received.empty() && subscriber.received.back().data == data;
        });
    }

    Lan lan{client_host};
};

TEST_P(AddressMove, AClientHearsTheHeirAndThenItsOwnBrokerAgainAtOneAddress) {
    if (!uses_arp()) take_ipv4_away();
    const auto r1 = start(1);
    const auto r2 = start(2);
    const auto r3 = start(3);
    ASSERT_TRUE(are_one_cluster({r1.get(), r2.get(), r3.get()}));
    const auto subscriber = client_of(1, "subscriber");
    const auto publisher = client_of(2, "publisher");
    ASSERT_TRUE(subscriber->connect());
    ASSERT_TRUE(subscriber->subscribe("pose", Qos::at_least_once));
    ASSERT_TRUE(publisher->connect());
    const auto topic = publisher->register_topic("pose");
    ASSERT_TRUE(topic);
    ASSERT_TRUE(reaches(*publisher, *topic, *subscriber, "before"));
    const int begun = subscriber->sessions_begun;
    ASSERT_EQ(lan.neighbour(client_host, address(1)), lan.mac_of(1));

    r1->kill_9();
    ASSERT_TRUE(reaches(*publisher, *topic, *subscriber, "after"));
    EXPECT_TRUE(subscriber->ping()) << "the way to the heir";
    const int heir = lan.has_address(2, address(1)) ? 2 : 3;
    EXPECT_TRUE(lan.has_address(heir, address(1)));
    EXPECT_EQ(arp_announce(heir), uses_arp() ? 2 : 0)
        << "it would ask for clients in the name of what it gave back";
    EXPECT_EQ(asks_neighbours_again_after_ms(heir), 100);
    EXPECT_EQ(lan.neighbour(client_host, address(1)), lan.mac_of(heir));

    const auto again = start(1);
    again->wait_until_serving();
    ASSERT_TRUE(is_in_view_of_all(*again));
    EXPECT_TRUE(eventually([&] { return !lan.has_address(heir, address(1)); }));
    ASSERT_TRUE(reaches(*publisher, *topic, *subscriber, "again"));
    EXPECT_TRUE(subscriber->ping()) << "the way to its own broker";
    EXPECT_EQ(lan.neighbour(client_host, address(1)), lan.mac_of(1));
    EXPECT_EQ(subscriber->sessions_begun, begun) << "the client noticed";
}

// The machine that had the address lives, and may name it as its own once more.
TEST_P(AddressMove, AnAddressThatMovedIsAnnouncedOftenInItsFirstSecond) {
    if (!uses_arp()) GTEST_SKIP() << "IPv6 has other frames, sent at the same times";
    const auto r1 = start(1);
    const auto r2 = start(2);
    const auto r3 = start(3);
    ASSERT_TRUE(are_one_cluster({r1.get(), r2.get(), r3.get()}));
    // Its session is held by a peer before it is answered: so they know that r1 serves there.
    const auto observer = client_of(1, "observer");
    ASSERT_TRUE(observer->connect());
    const Lan::On on(lan, client_host);
    r1->kill_9();
    const Announcements announcements(address(1));
    ASSERT_TRUE(announcements.hear_one());
    const auto first = std::chrono::steady_clock::now();
    for (int i = 0; i < 14; ++i) ASSERT_TRUE(announcements.hear_one());
    EXPECT_LT(std::chrono::steady_clock::now() - first, 5s)
        << "each is two frames: one a second would take seven";
}

TEST_P(AddressMove, WhatAKilledHeirTookOverDoesNotStayOnItsMachine) {
    auto r1 = start(1);
    const auto r2 = start(2);
    const auto r3 = start(3);
    ASSERT_TRUE(are_one_cluster({r1.get(), r2.get(), r3.get()}));
    const auto observer = client_of(1, "observer");
    ASSERT_TRUE(observer->connect());
    r1->kill_9();
    ASSERT_TRUE(eventually(
        [&] { return lan.has_address(2, address(1)) || lan.has_address(3, address(1)); }));
    const int heir = lan.has_address(2, address(1)) ? 2 : 3;
    (heir == 2 ? r2 : r3)->kill_9();
    EXPECT_TRUE(eventually([&] { return !lan.has_address(heir, address(1)); }));
    EXPECT_TRUE(observer->ping()) << "the last broker has it";
}

TEST_P(AddressMove, OneWithoutTheRightToAddAddressesSaysSoAndIsNoHeir) {
    const auto r1 = start(1);
    const auto r2 = start_without_right(2);
    const auto r3 = start(3);
    r1->wait_until_serving();
    r3->wait_until_serving();
    for (Process* broker : std::initializer_list<Process*>{r1.get(), r2.get(), r3.get()}) {
        ASSERT_TRUE(is_in_view_of_all(*broker)) << broker->errors();
    }
    EXPECT_NE(r2->errors().find("the right CAP_NET_ADMIN is missing"), std::string::npos)
        << r2->errors();
    const auto at_r3 = client_of(3, "more-to-do");  // r2 is the idlest
    ASSERT_TRUE(at_r3->connect());
    const auto client = client_of(1, "client");
    ASSERT_TRUE(client->connect());
    r1->kill_9();
    EXPECT_TRUE(eventually([&] { return lan.has_address(3, address(1)); })) << r2->errors();
    EXPECT_TRUE(client->ping());
    EXPECT_EQ(r2->errors().find("cannot serve"), std::string::npos) << r2->errors();
}

TEST_P(AddressMove, WhoMayNotServePlainClientsTakesNoPlainAddressOver) {
    const auto r1 = start(1);
    std::unique_ptr<BrokerProcess> r2;
    {
        const Lan::On on(lan, 2);
        r2 = std::make_unique<BrokerProcess>(
            std::vector<std::string>{"--listen", "127.0.0.1:1883", "--name", "r2", "--domain", "7",
                                     "--interface", "eth0", "--detection-timeout-ms", "500"});
    }
    for (const auto& broker : {r1.get(), r2.get()}) {
        broker->wait_until_serving();
        ASSERT_TRUE(eventually([&] {
            return broker->errors().find(" of 2, led by ") != std::string::npos;
        })) << broker->errors();
    }
    const auto client = client_of(1, "client");  // r2 holds its session before it has its answer
    ASSERT_TRUE(client->connect());
    r1->kill_9();
    EXPECT_TRUE(eventually([&] {
        return r2->errors().find("cannot serve " + service(1)) != std::string::npos;
    })) << r2->errors();
    EXPECT_NE(r2->errors().find("--allow-plain for plain addresses"), std::string::npos);
    EXPECT_FALSE(lan.has_address(2, address(1)));
}

TEST_P(AddressMove, WhoCannotServeAnAddressDoesNotKeepIt) {
    std::string where = service(1);
    where.back() = '4';
    const auto r1 = start(1, where);
    const auto r2 = start(2);
    for (const auto& broker : {r1.get(), r2.get()}) {
        broker->wait_until_serving();
        ASSERT_TRUE(eventually([&] {
            return broker->errors().find(" of 2, led by ") != std::string::npos;
        })) << broker->errors();
    }
    {
        const Lan::On on(lan, client_host);
        TestClient client(*net::parse_endpoint(GetParam().any), *net::parse_endpoint(where), "c");
        ASSERT_TRUE(client.connect());  // r2 holds its session before it has its answer
    }
    Endpoint everywhere = *net::parse_endpoint(GetParam().any);
    everywhere.port = 1884;
    const Lan::On on(lan, 2);
    const Stranger stranger(everywhere);
    r1->kill_9();
    ASSERT_TRUE(eventually([&] {
        return r2->errors().find("cannot serve " + where) != std::string::npos;
    })) << r2->errors();
    EXPECT_TRUE(eventually([&] { return !lan.has_address(2, address(1)); }))
        << "its lease is renewed";
}

TEST_P(AddressMove, WithoutTheRightAnAddressOfItsOwnThatTheMachineLacksIsRefused) {
    const Lan::On on(lan, 1);
    Process broker("/usr/bin/setpriv",
                   {"--bounding-set=-net_admin", ROMANO_BROKER, "--allow-plain", "--listen",
                    service(1), "--name", "r1", "--domain", "7", "--interface", "eth0"});
    EXPECT_EQ(broker.wait_for_exit(), 2);
    EXPECT_NE(broker.errors().find("--listen '" + service(1) +
                                   "': is no address of this machine, "
                                   "and the right to add it, CAP_NET_ADMIN, is missing"),
              std::string::npos)
        << broker.errors();
}

// The first of them added the address, and its lease would end five seconds after it was killed.
TEST_P(AddressMove, ABrokerOfTheSameMachineKeepsTheAddressThere) {
    auto r1 = start(1, service(1));
    const auto r2 = start(1, service(2));
    const auto r3 = start(3);
    ASSERT_TRUE(are_one_cluster({r1.get(), r2.get(), r3.get()}));
    const auto client = client_of(1, "client");
    ASSERT_TRUE(client->connect());
    r3->kill_9();  // so that r2 inherits
    const auto is_there_for = [&](std::chrono::milliseconds time) {
        const auto end = std::chrono::steady_clock::now() + time;
        while (std::chrono::steady_clock::now() < end) {
            if (!lan.has_address(1, address(1))) return false;
            std::this_thread::sleep_for(20ms);
        }
        return true;
    };
    r1->kill_9();
    EXPECT_TRUE(is_there_for(6500ms)) << "r2 says that it serves";
    EXPECT_TRUE(client->ping());

    r1 = start(1, service(1));
    EXPECT_TRUE(is_there_for(3s)) << "r2 gives it back, and takes it from the machine";
    r1->wait_until_serving();
    EXPECT_TRUE(client->ping());
    EXPECT_EQ(client->sessions_begun, 1) << "the client noticed";

    r2->signal(SIGTERM);
    EXPECT_EQ(r2->wait_for_exit(), 0);
    EXPECT_TRUE(is_there_for(1s)) << "r2 ends, and takes with it what r1 serves";
}

TEST_P(AddressMove, WhatTheMachineGotByDhcpIsNoLeaseOfABroker) {
    const Lan::On on(lan, 1);
    const std::string prefix = uses_arp() ? "/32" : "/128";
    for (const char* preferred_for : {"200", "0"}) {
        const auto ip = experiments::run_program(
            "ip", {"address", "replace", address(1) + prefix, "dev", "eth0", "valid_lft", "300",
                   "preferred_lft", preferred_for});
        ASSERT_EQ(ip.exit_code, 0) << ip.output;
        net::MovedAddresses::forget_earlier_life(*net::parse_endpoint(service(1)));
        EXPECT_TRUE(lan.has_address(1, address(1))) << "preferred for " << preferred_for << " s";
    }
}

TEST_P(AddressMove, WhatAnEarlierLifeAddedIsForgotten) {
    const Lan::On on(lan, 1);
    const Endpoint endpoint = *net::parse_endpoint(service(1));
    for (int times = 1; times <= 2; ++times) {  // it is renewed
        ASSERT_FALSE(net::add_address(endpoint, *net::interface_towards(endpoint), 60s));
    }
    EXPECT_TRUE(net::is_leased(endpoint));
    net::MovedAddresses::forget_earlier_life(endpoint);
    EXPECT_FALSE(lan.has_address(1, address(1)));
}

TEST_P(AddressMove, IsAddedAgainWhenItsInterfaceIsMadeAnew) {
    const Lan::On on(lan, 1);
    const auto ip = [](const std::vector<std::string>& words) {
        const auto done = experiments::run_program("ip", words);
        ASSERT_EQ(done.exit_code, 0) << done.output;
    };
    boost::asio::io_context io;
    int lost = 0;
    net::MovedAddresses moved(
        io, [](const Endpoint&) { return true; }, [&](const Endpoint&, const auto&) { ++lost; });
    ASSERT_FALSE(moved.add(*net::parse_endpoint(service(1))));
    ASSERT_TRUE(lan.has_address(1, address(1)));
    ip({"link", "del", "eth0"});
    io.run_for(2500ms);
    EXPECT_EQ(lost, 1) << "is told once";
    ip({"link", "add", "eth0", "type", "veth", "peer", "name", "other"});
    ip({"link", "set", "eth0", "up"});
    ip({"address", "add", uses_arp() ? "10.60.0.1/24" : "fd60::1/64", "dev", "eth0"});
    io.run_for(1500ms);
    EXPECT_TRUE(lan.has_address(1, address(1)));
    EXPECT_EQ(lost, 1);
}

INSTANTIATE_TEST_SUITE_P(Of, AddressMove,
                         testing::Values(Family{"IPv4", "10.60.0.10", "0.0.0.0:0"},
                                         Family{"IPv6", "fd60::10", "[::]:0"}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace romano::system::address_move_test
