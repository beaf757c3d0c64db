// Brokers at DTLS addresses as processes, clients that nobody here wrote, and our own robots and
// tools: they connect once, and go on through whatever happens to their brokers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "romano/keys/broker_record.h"
#include "tests/system/dtls_fleet.h"

namespace romano::system::dtls_test {
namespace {

using testing::HasSubstr;
using Octets = StandardClient::Octets;

// MQTT-SN 1.2, octet by octet.
const Octets connect{10, 4, 4, 1, 0, 60, 'a', 'n', 'n', 'a'};
const Octets connack{3, 5, 0};
const Octets subscribe{7, 18, 0x22, 0, 1, 'a', 'b'};
const Octets suback{8, 19, 0x20, 'a', 'b', 0, 1, 0};
const Octets ping{2, 22};
const Octets pong{2, 23};
Octets publish(std::uint8_t msg_id) {
    return {9, 12, 0x22, 'a', 'b', 0, msg_id, 'x', msg_id};
}
Octets puback(std::uint8_t msg_id) {
    return {7, 13, 'a', 'b', 0, msg_id, 0};
}

struct EitherClient : DtlsFleet, testing::WithParamInterface<bool> {};
INSTANTIATE_TEST_SUITE_P(OpensslAndGnutls, EitherClient, testing::Bool(),
                         [](const auto& each) { return each.param ? "Gnutls" : "Openssl"; });

TEST_P(EitherClient, IsServedByALoneBroker) {
    start_protected(1);
    const auto anna = standard_client(GetParam(), 1, psk("anna"));
    EXPECT_TRUE(anna->asks(connect, connack));
    EXPECT_TRUE(anna->asks(subscribe, suback));
    anna->say(publish(2));
    std::vector<Octets> heard{anna->hear(), anna->hear()};
    EXPECT_THAT(heard, testing::Contains(puback(2)));
    EXPECT_EQ(metric(1, handshakes), "1");
}

TEST_P(EitherClient, GoesOnAfterItsBrokerIsKilledAndAfterItIsBack) {
    start_both();
    const auto anna = standard_client(GetParam(), 1, psk("anna"));
    ASSERT_TRUE(anna->asks(connect, connack));
    ASSERT_TRUE(anna->asks(subscribe, suback));
    brokers[0]->kill_9();
    // On one machine the kernel says that nobody has a dead broker's port, and these clients end
    // when they hear that. From a dead machine nothing is heard.
    ASSERT_TRUE(comes_to_say(2, "romano_sessions{state=\"active\"}", "1"));
    EXPECT_TRUE(anna->asks(publish(2), puback(2)));
    EXPECT_TRUE(anna->asks(ping, pong));
    EXPECT_EQ(metric(2, handshakes), "0");
    EXPECT_EQ(metric(2, "romano_dtls_associations"), "1");

    start_member(1);  // waits until its address was handed back
    EXPECT_TRUE(anna->asks(publish(3), puback(3)));
    EXPECT_TRUE(anna->asks(ping, pong));
    EXPECT_EQ(metric(1, handshakes), "0") << "nor was there one now";
    EXPECT_EQ(metric(1, "romano_dtls_associations"), "1");
}

TEST_P(EitherClient, IsNotAnsweredWithAWrongKey) {
    start_protected(1);
    std::string wrong = psk("anna");
    wrong[5] = wrong[5] == '0' ? '1' : '0';
    const auto stranger = standard_client(GetParam(), 1, wrong);
    stranger->say(connect);
    EXPECT_EQ(stranger->hear(std::chrono::milliseconds{1'500}), Octets{});
    const auto anna = standard_client(GetParam(), 1, psk("anna"));
    EXPECT_TRUE(anna->asks(connect, connack));
    EXPECT_EQ(metric(1, handshakes), "1");
}

TEST_F(DtlsFleet, AClientWithACertificateGoesOnAfterItsBrokerIsKilled) {
    ASSERT_EQ(romano({"keys", "certificate", fleet.string(), "anna"}), 0) << said;
    start_both();
    const auto anna = client_with_certificate(1, fleet, "anna");
    ASSERT_TRUE(anna->asks(connect, connack));
    ASSERT_TRUE(anna->asks(subscribe, suback));
    brokers[0]->kill_9();
    ASSERT_TRUE(comes_to_say(2, "romano_sessions{state=\"active\"}", "1"));
    EXPECT_TRUE(anna->asks(publish(2), puback(2)));
    EXPECT_TRUE(anna->asks(ping, pong));
    EXPECT_EQ(metric(2, handshakes), "0");
    // And who has a pre-shared key is served beside it.
    const auto other = standard_client(false, 2, psk("anna"));
    EXPECT_TRUE(other->asks(connect, connack));
}

TEST_F(DtlsFleet, ACertificateOfAnotherFleetOrOfAWithdrawnClientIsRefused) {
    ASSERT_EQ(romano({"keys", "certificate", fleet.string(), "anna"}), 0) << said;
    const auto others = folder / "others";
    ASSERT_EQ(romano({"keys", "new", others.string(), "--operator", "anna"}), 0) << said;
    ASSERT_EQ(romano({"keys", "certificate", others.string(), "anna"}), 0) << said;
    // It shall believe the broker, so that it is refused for its own certificate.
    std::filesystem::copy_file(fleet / "authority.pem", others / "authority.pem",
                               std::filesystem::copy_options::overwrite_existing);
    start_protected(1);
    const auto stranger = client_with_certificate(1, others, "anna");
    stranger->say(connect);
    EXPECT_EQ(stranger->hear(std::chrono::milliseconds{5'000}), Octets{});
    EXPECT_TRUE(comes_to_say(1, "romano_dtls_handshakes_total{end=\"failed\"}", "1"));
    const auto anna = client_with_certificate(1, fleet, "anna");
    EXPECT_TRUE(anna->asks(connect, connack));
    ASSERT_EQ(romano({"keys", "withdraw", fleet.string(), "anna"}), 0) << said;
    ASSERT_TRUE(comes_to_say(1, "romano_dtls_associations", "0"));
    const auto again = client_with_certificate(1, fleet, "anna");
    again->say(connect);
    EXPECT_TRUE(comes_to_say(1, "romano_dtls_handshakes_total{end=\"failed\"}", "2"));
    EXPECT_EQ(romano({"keys", "certificate", fleet.string(), "anna"}), 2);
    EXPECT_THAT(said, HasSubstr("has no key here"));
}

TEST_F(DtlsFleet, ARobotHasTheSameRightsAsWithProtectedPackets) {
    start_protected(1);
    const auto robot = standard_client(false, 1, psk("abcd1234", keys::Role::robot));
    Octets as_robot{14, 4, 4, 1, 0, 60, 'a', 'b', 'c', 'd', '1', '2', '3', '4'};
    ASSERT_TRUE(robot->asks(as_robot, connack));
    EXPECT_TRUE(robot->asks(subscribe, {8, 19, 0, 0, 0, 0, 1, 3})) << "not supported";
    EXPECT_TRUE(robot->asks(connect, {3, 5, 3})) << "in anna's name";
}

TEST_F(DtlsFleet, APersonMovesARobot) {
    start_protected(1);
    const auto robot = robot_at(1, "30");
    EXPECT_THAT(robot->wait_for("established"), HasSubstr("abcd1234"));
    EXPECT_EQ(romano(at(1, "anna", {"move", "abcd1234", "front", "100mm"})), 0) << said;
    EXPECT_THAT(robot->wait_for("front 100 mm"), HasSubstr("x 100 mm"));
    EXPECT_EQ(romano(at(1, "anna", {"robots"})), 0) << said;
    EXPECT_THAT(said, HasSubstr("abcd1234"));
    robot->signal(SIGTERM);
    EXPECT_EQ(robot->wait_for_exit(), 0);
    EXPECT_TRUE(comes_to_say(1, "romano_dtls_associations", "0")) << "all said goodbye";
}

TEST_F(DtlsFleet, OurClientsLoseNothingAndMakeNoHandshakeWhenTheirBrokerIsKilled) {
    start_member(1);
    start_member(2, {"--listen", addresses.service(3)});  // plain: the test publishes there
    expect_both_in_view();
    Process listener(ROMANO_PROGRAM, at(1, "anna", {"sub", "-t", "number", "-q", "2", "-C", "60"}));
    const auto robot = robot_at(1, "30");
    EXPECT_THAT(robot->wait_for("established"), HasSubstr("abcd1234"));
    TestClient publisher(addresses.client(), addresses.service_endpoint(3), "somebody");
    ASSERT_TRUE(publisher.connect());
    const auto topic = publisher.register_topic("number");
    ASSERT_TRUE(topic);
    // Retained, because nobody says when it has subscribed.
    ASSERT_TRUE(publisher.publish(*topic, "0", mqttsn::Qos::exactly_once, true));
    EXPECT_EQ(listener.next_line(), "0");
    for (int i = 1; i < 60; ++i) {
        if (i == 20) brokers[0]->kill_9();
        ASSERT_TRUE(publisher.publish(*topic, std::to_string(i), mqttsn::Qos::exactly_once)) << i;
    }
    for (int i = 1; i < 60; ++i) ASSERT_EQ(listener.next_line(), std::to_string(i));
    EXPECT_EQ(listener.wait_for_exit(), 0);

    EXPECT_EQ(metric(2, handshakes), "0");
    EXPECT_EQ(romano(at(2, "anna", {"move", "abcd1234", "front", "100mm"})), 0) << said;
    EXPECT_THAT(robot->next_line(), HasSubstr("front 100 mm"))
        << "and it was not established again";
    EXPECT_TRUE(comes_to_say(2, handshakes, "1")) << "of the one who moved it";
}

TEST_F(DtlsFleet, ABrokerThatHasLostTheAssociationIsFoundByAnotherHandshake) {
    start_protected(1);
    const auto robot = robot_at(1, "1");
    EXPECT_THAT(robot->wait_for("established"), HasSubstr("abcd1234"));
    brokers[0]->kill_9();
    brokers.clear();
    start_protected(1);
    EXPECT_THAT(robot->wait_for("established", std::chrono::seconds{60}), HasSubstr("abcd1234"));
    EXPECT_EQ(metric(1, handshakes), "1");
}

TEST_F(DtlsFleet, WhatCannotBeIsOneSentence) {
    EXPECT_EQ(romano({"pub", "--dtls", "-t", "a", "-m", "b"}), 2);
    EXPECT_THAT(said, HasSubstr("--dtls requires --key"));
    EXPECT_EQ(romano(at(1, "anna", {"pub", "-q", "-1", "--predefined", "7", "-m", "b"})), 2);
    EXPECT_THAT(said, HasSubstr("-q -1 with --dtls"));
    EXPECT_EQ(romano(at(1, "anna", {"pub", "-t", "a", "-m", "b", "--broker-timeout", "0.4"})), 2);
    EXPECT_THAT(said, HasSubstr("nobody listens there"));
    start_protected(1);
    EXPECT_EQ(romano_at(1, {"pub", "-t", "a", "-m", "b", "--broker-timeout", "0.4", "--key",
                            keys.own_file("anna", keys::Role::person)}),
              2);
    EXPECT_THAT(said, HasSubstr("does it serve protected:// there"));
}

TEST_F(DtlsFleet, APlaceIsTakenOnceAndGoesWithTheRecordOfTheNumbers) {
    start_protected(1);
    brokers[0]->signal(SIGTERM);
    ASSERT_EQ(brokers[0]->wait_for_exit(), 0);
    const auto own = keys.broker_folder("r1");
    EXPECT_FALSE(std::filesystem::exists(own / keys::place_name)) << "it is in the record";
    std::filesystem::remove(own / keys::record_name);
    BrokerProcess again({"--listen", "dtls://" + addresses.service(1), "--keys", own});
    EXPECT_EQ(again.wait_for_exit(), 2);
    EXPECT_THAT(again.errors(), HasSubstr("has none; say `romano keys new FLEET --broker NAME`"));
    ASSERT_EQ(romano({"keys", "new", fleet.string(), "--broker", "r1"}), 0) << said;
    EXPECT_EQ(keys::read_given_place(own / keys::place_name), 3U) << "r2 has the second";
    start_protected(1);
}

TEST_F(DtlsFleet, AnAddressForDtlsNeedsKeys) {
    BrokerProcess broker({"--listen", "dtls://" + addresses.service(1)});
    EXPECT_EQ(broker.wait_for_exit(), 2);
    EXPECT_THAT(broker.errors(), HasSubstr("give --keys DIR"));
}

}  // namespace
}  // namespace romano::system::dtls_test
