// One romano-broker process and real clients.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"
#include "tests/system/test_client.h"

namespace romano::system::lone_broker_test {
namespace {

using mqttsn::Qos;

struct LoneBroker : testing::Test {
    TestAddresses addresses;
};

TEST_F(LoneBroker, SaysInOneLineThatItServes) {
    BrokerProcess broker(
        {"--listen", addresses.service(1), "--listen", addresses.service(2), "--name", "r1"});
    EXPECT_EQ(broker.next_line(),
              "romano-broker r1: serving " + addresses.service(1) + ", " + addresses.service(2));
    broker.signal(SIGTERM);
    EXPECT_EQ(broker.wait_for_exit(), 0);
    EXPECT_EQ(broker.next_line(), "");
}

TEST_F(LoneBroker, EndsInOrderOnSigint) {
    BrokerProcess broker({"--listen", addresses.service(1)});
    broker.wait_until_serving();
    broker.signal(SIGINT);
    EXPECT_EQ(broker.wait_for_exit(), 0);
}

struct LoneBrokerAtEachQos : LoneBroker, testing::WithParamInterface<Qos> {};

TEST_P(LoneBrokerAtEachQos, CarriesAPublishFromClientToClient) {
    BrokerProcess broker({"--listen", addresses.service(1)});
    broker.wait_until_serving();
    TestClient subscriber(addresses.client(), addresses.service_endpoint(1), "subscriber");
    TestClient publisher(addresses.client(), addresses.service_endpoint(1), "publisher");
    ASSERT_TRUE(subscriber.connect());
    ASSERT_TRUE(subscriber.subscribe("robots/+/pose", GetParam()));
    ASSERT_TRUE(publisher.connect());
    const auto topic = publisher.register_topic("robots/7/pose");
    ASSERT_TRUE(topic);
    for (int i = 0; i < 20; ++i) {
        ASSERT_TRUE(publisher.publish(*topic, "x=" + std::to_string(i), GetParam()));
    }
    ASSERT_TRUE(subscriber.run_until([&] { return subscriber.received.size() >= 20; }));
    for (std::size_t i = 0; i < 20; ++i) {
        EXPECT_EQ(subscriber.received[i].topic, "robots/7/pose");
        EXPECT_EQ(subscriber.received[i].data, "x=" + std::to_string(i));
        EXPECT_EQ(subscriber.received[i].qos, GetParam());
    }
}

INSTANTIATE_TEST_SUITE_P(All, LoneBrokerAtEachQos,
                         testing::Values(Qos::at_most_once, Qos::at_least_once, Qos::exactly_once),
                         [](const auto& test) { return "Qos" + std::to_string(test.index); });

TEST_F(LoneBroker, ServesIpv6) {
    BrokerProcess broker({"--listen", "[::1]:0", "--name", "six"});
    const std::string line = broker.next_line();
    const auto at = net::parse_endpoint(line.substr(line.rfind(' ') + 1));
    ASSERT_TRUE(at) << line;
    TestClient client(*net::parse_endpoint("[::1]:0"), *at, "c");
    ASSERT_TRUE(client.connect());
    EXPECT_TRUE(client.ping());
}

TEST_F(LoneBroker, AnswersFromTheAddressThatWasAskedWhenItServesAll) {
    BrokerProcess broker({"--listen", "0.0.0.0:0", "--allow-plain"});
    const std::string line = broker.next_line();
    Endpoint at = addresses.service_endpoint(9);
    at.port = net::parse_endpoint(line.substr(line.rfind(' ') + 1)).value().port;
    TestClient client(addresses.client(), at, "c");  // its socket hears this address only
    EXPECT_TRUE(client.connect());
}

TEST_F(LoneBroker, KnowsItsPredefinedTopics) {
    BrokerProcess broker({"--listen", addresses.service(1), "--predefined", "5=robots/stop"});
    broker.wait_until_serving();
    TestClient subscriber(addresses.client(), addresses.service_endpoint(1), "subscriber");
    ASSERT_TRUE(subscriber.connect());
    EXPECT_TRUE(subscriber.subscribe("robots/stop", Qos::at_least_once));
}

TEST_F(LoneBroker, TellsAboutItselfUnderSys) {
    BrokerProcess broker({"--listen", addresses.service(1), "--name", "r1"});
    broker.wait_until_serving();
    TestClient client(addresses.client(), addresses.service_endpoint(1), "c");
    ASSERT_TRUE(client.connect());
    ASSERT_TRUE(client.subscribe("$SYS/brokers/+", Qos::at_most_once));
    ASSERT_TRUE(client.run_until([&] { return !client.received.empty(); }));
    EXPECT_EQ(client.received.front().topic, "$SYS/brokers/r1");
    EXPECT_THAT(
        client.received.front().data,
        testing::AllOf(testing::HasSubstr(R"("alive":true)"), testing::HasSubstr(R"("name":"r1")"),
                       testing::HasSubstr(R"("cpu_percent":)"),
                       testing::HasSubstr(addresses.service(1))));
}

}  // namespace
}  // namespace romano::system::lone_broker_test
