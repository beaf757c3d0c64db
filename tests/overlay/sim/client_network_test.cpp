#include "overlay/sim/client_network.h"

#include <gtest/gtest.h>

#include <string>

namespace romano::sim::client_network_test {
namespace {

using namespace std::chrono_literals;

constexpr Node robot{1};
constexpr Node first{2};
constexpr Node second{3};
const Endpoint robot_address{.port = 5000, .family = Endpoint::Family::ipv4};
const Endpoint service{.port = 1883, .family = Endpoint::Family::ipv4};

class ClientNetworkTest : public testing::Test {
protected:
    ClientNetwork::Receiver noting(const std::string& who) {
        return [this, who](const Endpoint&, const Endpoint&, Bytes) { heard += who; };
    }
    void send() {
        network.send(robot, robot_address, service, as_octets("x"));
        events.run_for(1ms);
    }

    EventQueue events;
    Trace trace;
    ClientNetwork network{events, trace, 1};
    std::string heard;
};

TEST_F(ClientNetworkTest, TheNewestBindingGetsTheDatagrams) {
    (void)network.bind(service, first, noting("1"));
    const auto newer = network.bind(service, second, noting("2"));
    send();
    network.unbind(newer);
    send();
    EXPECT_EQ(heard, "21");
}

TEST_F(ClientNetworkTest, WhatNobodyServesVanishes) {
    const auto only = network.bind(service, first, noting("1"));
    network.unbind(only);
    send();
    EXPECT_EQ(heard, "");
}

TEST_F(ClientNetworkTest, ACutHidesABindingFromItsSender) {
    (void)network.bind(service, first, noting("1"));
    (void)network.bind(service, second, noting("2"));
    network.cuts().cut(robot, second, events.now());
    send();
    network.cuts().cut(robot, first, events.now());
    send();
    EXPECT_EQ(heard, "1");
}

TEST_F(ClientNetworkTest, OfTwoAtOneAddressTheOneThatTakesFromThereGetsTheDatagrams) {
    const auto from = [](const Endpoint& peer) {
        return [peer](const Endpoint& sender) { return sender == peer; };
    };
    (void)network.bind(service, first, noting("1"), from(robot_address));
    (void)network.bind(service, second, noting("2"), from(service));
    send();
    EXPECT_EQ(heard, "1");
}

TEST_F(ClientNetworkTest, LosesAndDoublesByItsQuality) {
    (void)network.bind(service, first, noting("1"));
    network.set_quality({.loss_ppm = 1'000'000});
    send();
    EXPECT_EQ(heard, "");
    network.set_quality({.duplication_ppm = 1'000'000});
    send();
    EXPECT_EQ(heard, "11");
}

}  // namespace
}  // namespace romano::sim::client_network_test
