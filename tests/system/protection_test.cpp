// Protected robots, people and brokers as processes, with keys of `romano keys`; and strangers.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/system/protected_fleet.h"

namespace romano::system::protection_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;
using testing::HasSubstr;
using Octets = std::vector<std::uint8_t>;

bool comes_to_warn(BrokerProcess& broker, const std::string& of) {
    const auto deadline = std::chrono::steady_clock::now() + 20s;
    while (broker.errors().find(of) == std::string::npos) {
        if (std::chrono::steady_clock::now() > deadline) return false;
        std::this_thread::sleep_for(20ms);
    }
    return true;
}

TEST_F(ProtectedFleet, APersonMovesARobot) {
    EXPECT_THAT(said, HasSubstr("robot abcd1234: move"));
    EXPECT_EQ(romano({"keys", "check", fleet.string()}), 0) << said;
    start_protected(1);
    Process robot(ROMANO_ROBOT, {"--key", keys.own_file("abcd1234", keys::Role::robot), "--broker",
                                 addresses.service(1)});
    EXPECT_THAT(robot.wait_for("established"), HasSubstr("abcd1234"));
    const std::string key = keys.own_file("anna", keys::Role::person);
    EXPECT_EQ(romano_at(1, {"move", "abcd1234", "front", "100mm", "--key", key}), 0) << said;
    EXPECT_THAT(robot.wait_for("front 100 mm"), HasSubstr("x 100 mm"));
    EXPECT_EQ(romano_at(1, {"robots", "--key", key}), 0) << said;
    EXPECT_THAT(said, HasSubstr("abcd1234"));
}

TEST_F(ProtectedFleet, TwoProgramsOfAPersonAreTwoClients) {
    start_protected(1);
    const std::string key = keys.own_file("anna", keys::Role::person);
    const std::string service = addresses.service(1);
    const auto colon = service.find(':');
    Process sub(ROMANO_PROGRAM, {"sub", "-h", service.substr(0, colon), "-p",
                                 service.substr(colon + 1), "--key", key, "-t", "pose", "-C", "1"});
    // Retained, because nobody says when it has subscribed.
    EXPECT_EQ(romano_at(1, {"pub", "--key", key, "-t", "pose", "-m", "x=1", "-q", "1", "-r"}), 0)
        << said;
    EXPECT_EQ(sub.wait_for("x=1"), "x=1");
    EXPECT_EQ(sub.wait_for_exit(), 0);
}

TEST_F(ProtectedFleet, WhoHasNoKeyOrAWrongOneIsNotAnsweredAndCounted) {
    start_protected(1);
    TestClient plain(addresses.client(), addresses.service_endpoint(1), "abcd1234");
    plain.send_octets(Octets{6, 4, 4, 1, 0, 10});
    EXPECT_TRUE(counts(1, "unprotected", 1));
    EXPECT_EQ(romano_at(1, {"pub", "-t", "pose", "-m", "x", "--broker-timeout", "0.4"}), 2);
    EXPECT_THAT(said, HasSubstr("no broker answered"));

    const auto robot = client_of(1, "abcd1234");
    ASSERT_TRUE(robot->connect());
    const Octets connect = robot->last_sent();
    plain.send_octets(connect);
    EXPECT_TRUE(counts(1, "replayed", 1)) << "from another address, too";
    ASSERT_TRUE(robot->ping());
    Octets forged = robot->last_sent();
    forged[19] += 1;  // the number: a new one
    plain.send_octets(forged);
    EXPECT_TRUE(counts(1, "bad_tag", 1));
    plain.send_octets(Bytes{forged}.first(20));
    EXPECT_TRUE(counts(1, "malformed", 1));
    EXPECT_TRUE(robot->ping());
    EXPECT_EQ(robot->sessions_begun, 1);

    keys::KeyFolder others(folder / "others");
    others.add({.brokers = {}, .robots = {"00000007", "00000008"}, .operators = {}});
    TestClient stranger(addresses.client(), addresses.service_endpoint(1),
                        KeyFile{others.own_file("00000008", keys::Role::robot)});
    stranger.send_octets(stranger.sealed(mqttsn::Pingreq{""}));
    EXPECT_TRUE(counts(1, "unknown_sender", 1));
    TestClient liar(addresses.client(), addresses.service_endpoint(1),
                    KeyFile{others.own_file("00000007", keys::Role::robot)});
    liar.send_octets(liar.sealed(mqttsn::Pingreq{""}));
    EXPECT_TRUE(counts(1, "bad_tag", 2));
}

TEST_F(ProtectedFleet, NobodyConnectsInAnothersName) {
    start_protected(1);
    const auto robot = client_of(1, "abcd1234");
    robot->set_client_id("00000007");
    EXPECT_FALSE(robot->connect());
    EXPECT_TRUE(counts(1, "foreign_client_id", 1));
    robot->set_client_id("abcd1234");
    EXPECT_TRUE(robot->connect());
}

TEST_F(ProtectedFleet, AClientWithAKeyNeedsItAtThePlainAddressToo) {
    start_protected(1, {"--listen", addresses.service(3)});
    TestClient plain(addresses.client(), addresses.service_endpoint(3), "somebody");
    EXPECT_TRUE(plain.connect());
    TestClient impostor(addresses.client(), addresses.service_endpoint(3), "abcd1234");
    EXPECT_FALSE(impostor.connect());
    EXPECT_TRUE(counts(1, "needs_protection", 1));
}

TEST_F(ProtectedFleet, WhoFloodsThePlainAddressInItsNameHearsFewAnswers) {
    start_protected(1, {"--listen", addresses.service(3), "--max-stranger-answers", "1"});
    TestClient impostor(addresses.client(), addresses.service_endpoint(3), "abcd1234");
    EXPECT_FALSE(impostor.connect());
    const Octets connect = impostor.last_sent();
    for (int i = 0; i < 1'000; ++i) impostor.send_octets(connect);
    EXPECT_TRUE(counts(1, "stranger_rate", 1));
    EXPECT_TRUE(client_of(1, "abcd1234")->connect());
}

TEST_F(ProtectedFleet, AWithdrawnRobotIsRefusedWhileTheBrokerRuns) {
    start_protected(1);
    const auto robot = client_of(1, "abcd1234");
    ASSERT_TRUE(robot->connect());
    const auto other = client_of(1, "00000007");
    ASSERT_TRUE(other->connect());
    ASSERT_EQ(romano({"keys", "withdraw", fleet.string(), "abcd1234"}), 0) << said;
    ASSERT_TRUE(
        metrics_come_to_say(addresses.service_endpoint(1), "romano_protected_clients", 17, 17));
    robot->send_octets(robot->sealed(mqttsn::Pingreq{""}));
    EXPECT_TRUE(counts(1, "unknown_sender", 1));
    EXPECT_TRUE(other->ping());
}

TEST_F(ProtectedFleet, ATableThatOthersMayReadIsReadOnceTheyMayNot) {
    BrokerProcess& broker = start_protected(1);
    const auto table = keys.broker_folder("r1") / keys::table_name;
    std::filesystem::permissions(table, std::filesystem::perms::others_read,
                                 std::filesystem::perm_options::add);
    std::ofstream(table, std::ios::app) << "robot 00000009 " << std::string(32, 'a') << '\n';
    ASSERT_TRUE(comes_to_warn(broker, "others may read"));
    std::filesystem::permissions(table, std::filesystem::perms::others_read,
                                 std::filesystem::perm_options::remove);
    EXPECT_TRUE(
        metrics_come_to_say(addresses.service_endpoint(1), "romano_protected_clients", 19, 19));
    EXPECT_TRUE(client_of(1, "abcd1234")->connect());
}

TEST_F(ProtectedFleet, APartOfATableLocksNobodyOut) {
    BrokerProcess& broker = start_protected(1);
    const auto table = keys.broker_folder("r1") / keys::table_name;
    std::ifstream in(table);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    std::ofstream{table};
    ASSERT_TRUE(comes_to_warn(broker, "is empty"));
    EXPECT_TRUE(client_of(1, "abcd1234")->connect());
    const std::size_t cut = whole.size() / 2;
    std::ofstream(table) << whole.substr(0, whole[cut - 1] == '\n' ? cut - 1 : cut);
    ASSERT_TRUE(comes_to_warn(broker, "has no end"));
    EXPECT_TRUE(client_of(1, "00000007")->connect());
    std::ofstream(table) << whole << "robot 00000009 " << std::string(32, 'a') << '\n';
    EXPECT_TRUE(
        metrics_come_to_say(addresses.service_endpoint(1), "romano_protected_clients", 19, 19));
}

TEST_F(ProtectedFleet, AKilledBrokerTakesNoOldPacketAndItsClientConnectsAgain) {
    start_protected(1);
    const auto robot = client_of(1, "abcd1234");
    ASSERT_TRUE(robot->connect());
    ASSERT_TRUE(robot->ping());
    const Octets old = robot->last_sent();
    brokers[0]->kill_9();
    brokers.clear();
    start_protected(1);
    robot->send_octets(old);
    EXPECT_TRUE(counts(1, "replayed", 1));
    EXPECT_TRUE(robot->connect());
    EXPECT_TRUE(robot->ping());
}

TEST_F(ProtectedFleet, AnOrderlyRestartIsNoticedByNobodyWhoseSessionIsStored) {
    const std::vector<std::string> with_store{"--store", folder / "store.db"};
    start_protected(1, with_store);
    const auto robot = client_of(1, "abcd1234");
    ASSERT_TRUE(robot->connect());
    brokers[0]->signal(SIGTERM);
    ASSERT_EQ(brokers[0]->wait_for_exit(), 0);
    brokers.clear();
    start_protected(1, with_store);
    EXPECT_TRUE(robot->ping());
    EXPECT_EQ(robot->sessions_begun, 1);
}

/// What the client got: at QoS 2 each as often as that, at QoS 1 once, as it may come again.
std::multiset<std::string> contents(const TestClient& client, Qos qos) {
    std::multiset<std::string> out;
    for (const auto& delivery : client.received) {
        if (qos == Qos::exactly_once || !out.contains(delivery.data)) out.insert(delivery.data);
    }
    return out;
}

struct ProtectedCluster : ProtectedFleet, testing::WithParamInterface<Qos> {};

TEST_P(ProtectedCluster, AKilledBrokersClientGoesOnWithoutAConnectAndLosesNothing) {
    start_both();
    const auto subscriber = client_of(1, "abcd1234");
    const auto publisher = client_of(2, "anna");
    ASSERT_TRUE(subscriber->connect());
    ASSERT_TRUE(subscriber->subscribe("robots/abcd1234/pose", GetParam()));
    ASSERT_TRUE(publisher->connect());
    const auto topic = publisher->register_topic("robots/abcd1234/pose");
    ASSERT_TRUE(topic);
    const int begun = subscriber->sessions_begun;
    std::multiset<std::string> published;
    for (int i = 0; i < 60; ++i) {
        if (i == 20) brokers[0]->kill_9();
        ASSERT_TRUE(publisher->publish(*topic, std::to_string(i), GetParam())) << i;
        published.insert(std::to_string(i));
        subscriber->run_until([] { return false; }, 2ms);
    }
    EXPECT_TRUE(subscriber->run_until([&] {
        return contents(*subscriber, GetParam()) == published;
    })) << contents(*subscriber, GetParam()).size()
        << " of " << published.size();
    const Octets old = subscriber->last_sent();
    EXPECT_TRUE(subscriber->ping());
    subscriber->send_octets(old);
    EXPECT_TRUE(counts(2, "replayed", 1));
    EXPECT_EQ(subscriber->sessions_begun, begun) << "the client noticed";
}

INSTANTIATE_TEST_SUITE_P(Each, ProtectedCluster,
                         testing::Values(Qos::at_least_once, Qos::exactly_once),
                         [](const auto& test) { return "Qos" + std::to_string(test.index + 1); });

TEST_P(ProtectedCluster, WhoComesBackGoesOnWhereTheOtherOneStands) {
    start_both();
    const auto robot = client_of(1, "abcd1234");
    ASSERT_TRUE(robot->connect());
    const int begun = robot->sessions_begun;
    brokers[0]->kill_9();
    ASSERT_TRUE(robot->ping());
    const Octets old = robot->last_sent();
    start_member(1);
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(robot->ping()) << i;
    robot->send_octets(old);
    EXPECT_TRUE(counts(1, "replayed", 1));
    EXPECT_EQ(robot->sessions_begun, begun);
}

TEST_F(ProtectedFleet, WhatIsWrongWithKeysIsOneSentence) {
    const auto refusal = [&](const std::vector<std::string>& arguments) {
        Process broker(ROMANO_BROKER, arguments);
        EXPECT_EQ(broker.wait_for_exit(), 2);
        return broker.errors();
    };
    const std::string at = "protected://" + addresses.service(1);
    EXPECT_THAT(refusal({"--listen", at}), HasSubstr("needs the keys of its clients"));
    EXPECT_THAT(refusal({"--listen", at, "--keys", folder / "none"}), HasSubstr("--keys '"));
    EXPECT_THAT(refusal({"--listen", addresses.service(1), "--keys", fleet.string()}),
                HasSubstr("is for clients with keys; give --listen"));
    const auto table = keys.broker_folder("r1") / keys::table_name;
    std::filesystem::permissions(table, std::filesystem::perms::others_read,
                                 std::filesystem::perm_options::add);
    EXPECT_THAT(refusal({"--listen", at, "--keys", keys.broker_folder("r1")}),
                HasSubstr("chmod 600"));
    EXPECT_EQ(romano({"keys", "check", fleet.string()}), 1);
    EXPECT_THAT(said, HasSubstr("chmod 600"));
    EXPECT_EQ(romano({"pub", "--key", table.string(), "-t", "a", "-m", "b"}), 2);
}

}  // namespace
}  // namespace romano::system::protection_test
