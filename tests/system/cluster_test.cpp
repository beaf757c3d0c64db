// Several romano-broker processes that are one broker, and unmodified clients.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <memory>
#include <set>
#include <string_view>
#include <thread>

#include "broker/net/clock.h"
#include "overlay/dds/dds_transport.h"
#include "overlay/dds/domain.h"
#include "overlay/dds/peer_writers.h"
#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"
#include "tests/system/test_client.h"

namespace romano::system::cluster_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

struct Cluster : testing::Test {
    [[nodiscard]] std::unique_ptr<BrokerProcess> start(int n) const {
        return std::make_unique<BrokerProcess>(std::vector<std::string>{
            "--listen", addresses.service(n), "--name", "r" + std::to_string(n), "--domain",
            std::to_string(addresses.domain()), "--interface", "lo", "--rank", std::to_string(n),
            "--detection-timeout-ms", std::to_string(detection_timeout.count()), "--log-level",
            "debug"});
    }
    /// Brokers r1 to rN, each of which knows all others.
    void start_all(int count) {
        for (int n = 1; n <= count; ++n) brokers.push_back(start(n));
        for (int n = 1; n <= count; ++n) broker(n).wait_until_serving();
        for (int n = 1; n <= count; ++n) ASSERT_TRUE(wait_for_view_of(count, n));
    }
    [[nodiscard]] BrokerProcess& broker(int n) { return *brokers[static_cast<std::size_t>(n - 1)]; }
    [[nodiscard]] std::unique_ptr<TestClient> client_of(int n, const std::string& id) const {
        return std::make_unique<TestClient>(addresses.client(), addresses.service_endpoint(n), id);
    }
    /// Asks broker n, as people do, until its view has `count` members.
    bool wait_for_view_of(int count, int n) const {
        const auto client = client_of(n, "observer-" + std::to_string(n));
        if (!client->connect() || !client->subscribe("$SYS/brokers/+", Qos::at_most_once)) {
            return false;
        }
        return client->run_until([&] {
            if (client->received.empty()) return false;
            const std::string& last = client->received.back().data;
            const auto from = last.find("\"members\":[");
            if (from == std::string::npos) return false;
            const auto list = last.substr(from, last.find(']', from) - from);
            return std::ranges::count(list, 'r') == count + 1;  // and the one of "members"
        });
    }

    TestAddresses addresses;
    std::chrono::milliseconds detection_timeout{300};
    std::vector<std::unique_ptr<BrokerProcess>> brokers;
};

// Each broker's link to each other one is up soon after the start, whoever was first.
TEST_F(Cluster, ACrashIsKnownFromTheLinksLongBeforeTheBeaconsAreMissed) {
    detection_timeout = 2s;
    start_all(3);
    const auto client = client_of(1, "client");
    ASSERT_TRUE(client->connect());
    client->repeats_after = 50ms;
    broker(1).kill_9();
    const auto killed = std::chrono::steady_clock::now();
    EXPECT_TRUE(client->ping()) << broker(2).errors();
    EXPECT_LT(std::chrono::steady_clock::now() - killed, detection_timeout / 2);
}

// Its peers would not hear it: an hour ago they heard one that calls itself later.
TEST_F(Cluster, ABrokerWhoseClockWentBackBeginsAgainAfterItsLaterLife) {
    const dds::Domain domain(dds::DomainOptions{addresses.domain(), "lo"});
    const dds::Entity participant = domain.make_participant();
    const auto in_an_hour = static_cast<std::uint64_t>((net::unix_time() + 1h).count());
    const broker::LogId later{broker::broker_id_of("r1"), in_an_hour};
    const dds::PeerWriters peer(participant, {broker::broker_id_of("peer"), 1}, later);
    const auto broker = start(1);
    ASSERT_FALSE(broker->wait_for("serving").empty()) << broker->errors();
    ASSERT_FALSE(broker->wait_for("serving").empty()) << broker->errors();
    EXPECT_THAT(broker->errors(), testing::HasSubstr("begins again as the next life"));
    const auto client = client_of(1, "observer");
    ASSERT_TRUE(client->connect());
    ASSERT_TRUE(client->subscribe("$SYS/brokers/r1", Qos::at_most_once));
    ASSERT_TRUE(client->run_until([&] { return !client->received.empty(); }));
    const std::string& status = client->received.back().data;
    const std::string_view field = "\"incarnation\":";
    const std::size_t at = status.find(field);
    ASSERT_NE(at, std::string::npos) << status;
    EXPECT_GT(std::stoull(status.substr(at + field.size())), in_an_hour);
}

TEST_F(Cluster, ABrokerWhoseLaterNamesakeIsSwitchedOffBeginsAgainAfterIt) {
    const auto in_an_hour = static_cast<std::uint64_t>((net::unix_time() + 1h).count());
    const broker::LogId later{broker::broker_id_of("r1"), in_an_hour};
    const dds::Domain domain(dds::DomainOptions{addresses.domain(), "lo"});
    const dds::Entity participant = domain.make_participant();
    const dds::PeerWriters peer(participant, {broker::broker_id_of("peer"), 1}, later);
    boost::asio::io_context io;  // it only speaks
    dds::DdsTransport namesake(io, domain, later, overlay::Pulses(1h, 1h));
    namesake.start([](const overlay::Envelope&) {});
    const auto live_until = [&](auto done) {
        for (const auto limit = net::now() + 20s; !done() && net::now() < limit;) {
            namesake.send({std::nullopt, cluster::Heartbeat{}});
            std::this_thread::sleep_for(10ms);
        }
        return done();
    };
    const auto broker = start(1);
    ASSERT_TRUE(live_until([&] {
        return broker->errors().find("another broker is named r1") != std::string::npos;
    })) << broker->errors();
    const auto long_after = net::now() + 3 * detection_timeout;
    ASSERT_TRUE(live_until([&] { return net::now() > long_after; }));
    EXPECT_THAT(broker->errors(), testing::Not(testing::HasSubstr("begins again")));
    ASSERT_FALSE(broker->wait_for("serving").empty()) << broker->errors();
    ASSERT_FALSE(broker->wait_for("serving").empty()) << broker->errors();
    EXPECT_THAT(broker->errors(), testing::HasSubstr("begins again as the next life"));
}

TEST_F(Cluster, SaysWhereItServes) {
    const auto broker = start(1);
    EXPECT_EQ(broker->next_line(), "romano-broker r1: serving " + addresses.service(1) +
                                       " (domain " + std::to_string(addresses.domain()) +
                                       " on lo)");
    broker->signal(SIGTERM);
    EXPECT_EQ(broker->wait_for_exit(), 0);
}

struct ClusterAtEachQos : Cluster, testing::WithParamInterface<Qos> {};

TEST_P(ClusterAtEachQos, PublishesCrossBrokers) {
    start_all(2);
    const auto subscriber = client_of(1, "subscriber");
    const auto publisher = client_of(2, "publisher");
    ASSERT_TRUE(subscriber->connect());
    ASSERT_TRUE(subscriber->subscribe("robots/+/pose", GetParam()));
    ASSERT_TRUE(publisher->connect());
    const auto topic = publisher->register_topic("robots/7/pose");
    ASSERT_TRUE(topic);
    if (GetParam() == Qos::at_most_once) {
        // The other broker learns of the subscription, and the path is best-effort: until one came.
        for (int i = 0; i < 200 && subscriber->received.empty(); ++i) {
            publisher->publish(*topic, "x", GetParam());
            subscriber->run_until([&] { return !subscriber->received.empty(); }, 50ms);
        }
        EXPECT_FALSE(subscriber->received.empty());
        return;
    }
    for (int i = 0; i < 20; ++i) {
        ASSERT_TRUE(publisher->publish(*topic, std::to_string(i), GetParam()));
    }
    ASSERT_TRUE(subscriber->run_until([&] { return subscriber->received.size() >= 20; }));
    for (std::size_t i = 0; i < 20; ++i) {
        EXPECT_EQ(subscriber->received[i].topic, "robots/7/pose");
        EXPECT_EQ(subscriber->received[i].data, std::to_string(i));
    }
}

INSTANTIATE_TEST_SUITE_P(All, ClusterAtEachQos,
                         testing::Values(Qos::at_most_once, Qos::at_least_once, Qos::exactly_once),
                         [](const auto& test) { return "Qos" + std::to_string(test.index); });

struct ClusterLosing : Cluster, testing::WithParamInterface<int> {
    /// The distinct contents that the client got.
    static std::set<std::string> contents(const TestClient& client) {
        std::set<std::string> out;
        for (const auto& delivery : client.received) out.insert(delivery.data);
        return out;
    }
};

TEST_P(ClusterLosing, AKilledBrokersClientsReceiveAgainAtTheSameAddress) {
    const int victim = GetParam();
    start_all(3);
    // The subscriber lives with the victim, the publisher with another one.
    const auto subscriber = client_of(victim, "subscriber");
    const auto publisher = client_of(victim % 3 + 1, "publisher");
    ASSERT_TRUE(subscriber->connect());
    ASSERT_TRUE(subscriber->subscribe("robots/pose", Qos::at_least_once));
    ASSERT_TRUE(publisher->connect());
    const auto topic = publisher->register_topic("robots/pose");
    ASSERT_TRUE(topic);
    const int begun = subscriber->sessions_begun;
    std::set<std::string> acknowledged;
    for (int i = 0; i < 60; ++i) {
        if (i == 20) broker(victim).kill_9();
        ASSERT_TRUE(publisher->publish(*topic, std::to_string(i), Qos::at_least_once)) << i;
        acknowledged.insert(std::to_string(i));
        subscriber->run_until([] { return false; }, 2ms);  // answers what has arrived
    }
    EXPECT_TRUE(subscriber->run_until([&] { return contents(*subscriber) == acknowledged; }))
        << contents(*subscriber).size() << " of " << acknowledged.size();
    EXPECT_EQ(subscriber->sessions_begun, begun) << "the client noticed";
    for (const auto& delivery : subscriber->received) EXPECT_EQ(delivery.topic, "robots/pose");

    // It can also speak: same address, nothing begun anew.
    EXPECT_TRUE(subscriber->ping());
}

INSTANTIATE_TEST_SUITE_P(Each, ClusterLosing, testing::Values(1, 2, 3),
                         [](const auto& test) { return "R" + std::to_string(test.param); });

TEST_P(ClusterLosing, Qos2StaysExactlyOnceWhenTheHomeOfBothClientsIsKilled) {
    const int victim = GetParam();
    start_all(3);
    const auto subscriber = client_of(victim, "subscriber");
    const auto publisher = client_of(victim, "publisher");
    ASSERT_TRUE(subscriber->connect());
    ASSERT_TRUE(subscriber->subscribe("robots/pose", Qos::exactly_once));
    ASSERT_TRUE(publisher->connect());
    const auto topic = publisher->register_topic("robots/pose");
    ASSERT_TRUE(topic);
    for (int i = 0; i < 60; ++i) {
        if (i == 20) broker(victim).kill_9();
        ASSERT_TRUE(publisher->publish(*topic, std::to_string(i), Qos::exactly_once)) << i;
        subscriber->run_until([] { return false; }, 2ms);
    }
    EXPECT_TRUE(subscriber->run_until([&] { return subscriber->received.size() >= 60; }, 30s));
    ASSERT_EQ(subscriber->received.size(), 60U);
    for (std::size_t i = 0; i < 60; ++i) {
        EXPECT_EQ(subscriber->received[i].data, std::to_string(i)) << "order and once";
    }
}

TEST_F(Cluster, ABrokerThatStoodStillIsReplacedAndComesBackUnnoticed) {
    start_all(3);
    const auto subscriber = client_of(1, "subscriber");
    const auto publisher = client_of(2, "publisher");
    ASSERT_TRUE(subscriber->connect());
    ASSERT_TRUE(subscriber->subscribe("robots/pose", Qos::exactly_once));
    ASSERT_TRUE(publisher->connect());
    const auto topic = publisher->register_topic("robots/pose");
    ASSERT_TRUE(topic);
    const int begun = subscriber->sessions_begun;
    std::size_t published = 0;
    const auto publish_and_receive = [&](int count) {
        for (int i = 0; i < count; ++i) {
            ASSERT_TRUE(publisher->publish(*topic, std::to_string(published++), Qos::exactly_once));
            subscriber->run_until([] { return false; }, 2ms);
        }
        EXPECT_TRUE(
            subscriber->run_until([&] { return subscriber->received.size() >= published; }, 30s))
            << subscriber->received.size() << " of " << published;
    };
    publish_and_receive(20);
    broker(1).signal(SIGSTOP);
    publish_and_receive(20);  // served by a survivor
    broker(1).signal(SIGCONT);
    publish_and_receive(40);
    // It has its client back once it says so itself; then it serves on alone.
    ASSERT_TRUE(wait_for_view_of(3, 1));
    publish_and_receive(20);
    ASSERT_EQ(subscriber->received.size(), published);
    for (std::size_t i = 0; i < published; ++i) {
        EXPECT_EQ(subscriber->received[i].data, std::to_string(i)) << "order and once";
    }
    EXPECT_EQ(subscriber->sessions_begun, begun) << "the client noticed";
}

TEST_F(Cluster, ARestartedBrokerGetsItsAddressAndClientsBackUnnoticed) {
    start_all(2);
    const auto subscriber = client_of(1, "subscriber");
    const auto publisher = client_of(2, "publisher");
    ASSERT_TRUE(subscriber->connect());
    ASSERT_TRUE(subscriber->subscribe("robots/pose", Qos::at_least_once));
    ASSERT_TRUE(publisher->connect());
    const auto topic = publisher->register_topic("robots/pose");
    ASSERT_TRUE(topic);
    const int begun = subscriber->sessions_begun;
    const auto send_and_receive = [&](const std::string& data) {
        ASSERT_TRUE(publisher->publish(*topic, data, Qos::at_least_once));
        ASSERT_TRUE(subscriber->run_until([&] {
            return !subscriber->received.empty() && subscriber->received.back().data == data;
        })) << data;
    };
    send_and_receive("before");
    broker(1).kill_9();
    send_and_receive("while it is dead");
    brokers[0] = start(1);
    broker(1).wait_until_serving();
    ASSERT_TRUE(wait_for_view_of(2, 1));
    send_and_receive("after it came back");
    EXPECT_TRUE(subscriber->ping());
    EXPECT_EQ(subscriber->sessions_begun, begun) << "the client noticed";

    // It really is back: without the other one it serves on.
    broker(2).kill_9();
    EXPECT_TRUE(subscriber->ping());
    EXPECT_EQ(subscriber->sessions_begun, begun) << "the client noticed";
}

TEST_F(Cluster, ANewcomerDisturbsNoClientOfTheOthers) {
    start_all(2);
    const auto client = client_of(1, "client");
    ASSERT_TRUE(client->connect());
    ASSERT_TRUE(client->subscribe("robots/pose", Qos::at_least_once));
    const auto topic = client->register_topic("robots/pose");
    ASSERT_TRUE(topic);
    const int begun = client->sessions_begun;
    brokers.push_back(start(3));
    // Under traffic all the time until the newcomer has settled.
    int published = 0;
    bool settled = false;
    for (; published < 3000 && !settled; ++published) {
        ASSERT_TRUE(client->publish(*topic, std::to_string(published), Qos::at_least_once));
        settled = published % 50 == 49 && broker(3).errors().find("of 3") != std::string::npos;
    }
    ASSERT_TRUE(settled);
    broker(3).wait_until_serving();
    ASSERT_TRUE(client->publish(*topic, "the last", Qos::at_least_once));
    EXPECT_TRUE(client->run_until([&] { return client->received.back().data == "the last"; }));
    EXPECT_EQ(client->sessions_begun, begun) << "the client noticed";
    EXPECT_EQ(client->received.size(), static_cast<std::size_t>(published) + 1);
}

TEST_F(Cluster, AnOrderlyLeaveHandsTheClientsOver) {
    start_all(2);
    const auto client = client_of(1, "client");
    ASSERT_TRUE(client->connect());
    const int begun = client->sessions_begun;
    broker(1).signal(SIGTERM);
    EXPECT_EQ(broker(1).wait_for_exit(), 0);
    EXPECT_TRUE(client->ping());
    EXPECT_EQ(client->sessions_begun, begun) << "the client noticed";
}

}  // namespace
}  // namespace romano::system::cluster_test
