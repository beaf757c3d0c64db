#include "experiments/testbed/hosts_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/testbed/fleet_at_work.h"

namespace romano::experiments::hosts_file_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr const char* two_hosts = R"(
ssh_options = ["-i", "/home/anna/key"]
interface = "wlan0"
broker_options = ["--profile", "wifi"]

[[hosts]]
name = "pi1"
ssh = "pi@192.168.1.11"
addresses = ["192.168.1.101", "fd00:0::1"]
ssh_options = ["-p", "2222"]

[[hosts]]
ssh = "pi5"
role = "robots"
interface = "eth1"
robots = 3
)";

std::string refusal_of(const std::string& text) {
    try {
        (void)parse_hosts(text, "hosts.toml");
    } catch (const SettingError& error) {
        return error.what();
    }
    return "nothing was refused";
}

std::string with(const std::string& line) {
    return "[[hosts]]\nname = \"pi1\"\nssh = \"pi\"\naddresses = [\"10.0.0.1\"]\n" + line + "\n";
}

TEST(HostsFile, WhatStandsAboveTheHostsIsForAllOfThem) {
    const Testbed testbed = parse_hosts(two_hosts, "hosts.toml");
    ASSERT_THAT(testbed.hosts, SizeIs(2));
    const Host& broker = testbed.hosts[0];
    EXPECT_EQ(broker.interface, "wlan0");
    EXPECT_THAT(broker.ssh_options, ElementsAre("-i", "/home/anna/key", "-p", "2222"));
    EXPECT_THAT(broker.broker_options, ElementsAre("--profile", "wifi"));
    EXPECT_THAT(broker.addresses, ElementsAre("192.168.1.101", "fd00::1"));
    const Host& robots = testbed.hosts[1];
    EXPECT_EQ(robots.name, "host2");
    EXPECT_EQ(robots.interface, "eth1");
    EXPECT_EQ(robots.role, HostRole::robots);
    EXPECT_EQ(robots.robots, 3U);
    EXPECT_THAT(testbed.addresses(), ElementsAre("192.168.1.101", "fd00::1"));
}

TEST(HostsFile, RefusesInOneSentenceThatNamesTheSetting) {
    EXPECT_THAT(refusal_of(""), HasSubstr("no host"));
    EXPECT_THAT(refusal_of("hosts = 3"), HasSubstr("`hosts = 3`: tables are allowed"));
    EXPECT_THAT(refusal_of("[[hosts]\n"), HasSubstr("line 1: no TOML"));
    EXPECT_THAT(refusal_of("[[hosts]]\n"), HasSubstr("host `host1` has no `ssh`"));
    EXPECT_THAT(refusal_of("[[hosts]]\nssh = \"pi\"\n"), HasSubstr("has no `addresses`"));
    EXPECT_THAT(refusal_of(with("colour = 1")), HasSubstr("unknown setting `hosts.colour`"));
    EXPECT_THAT(refusal_of(with("role = \"leader\"")), HasSubstr("allowed are brokers, robots"));
    EXPECT_THAT(refusal_of(with("folder = \"a b\"")), HasSubstr("`hosts.folder = \"a b\"`"));
    EXPECT_THAT(refusal_of(with("folder = \"/a;reboot\"")), HasSubstr("a path from /"));
    EXPECT_THAT(refusal_of(with("broker_options = [\"--name=x\"]")),
                HasSubstr("the testbed itself sets --name"));
    EXPECT_THAT(refusal_of(with("") + with("")), HasSubstr("two hosts are called `pi1`"));
    EXPECT_THAT(refusal_of("[[hosts]]\nname = \"A/b\"\nssh = \"pi\"\n"), HasSubstr("lower-case"));
    // ssh would take it for one of its options.
    EXPECT_THAT(refusal_of("[[hosts]]\nssh = \"-oProxyCommand=x\"\naddresses = [\"10.0.0.1\"]\n"),
                HasSubstr("a destination"));
    for (const char* address : {"pi1", "0.0.0.0", "127.0.0.1", "239.1.1.1", "10.0.0.1:1883"}) {
        EXPECT_THAT(
            refusal_of("[[hosts]]\nssh = \"pi\"\naddresses = [\"" + std::string{address} + "\"]\n"),
            HasSubstr("`" + std::string{address} + "` is none"));
    }
}

TEST(HostsFile, OfThisRepositoryIsValid) {
    const Testbed testbed = read_hosts(ROMANO_SOURCE_DIR "/experiments/testbed/hosts.toml");
    EXPECT_THAT(testbed.hosts, SizeIs(5));
}

TEST(HostsFile, AnAddressBelongsToOneBroker) {
    EXPECT_THAT(refusal_of(with("") + "[[hosts]]\nssh = \"pi2\"\naddresses = [\"10.0.0.1\"]\n"),
                HasSubstr("10.0.0.1 stands there twice"));
}

TEST(HostsFile, EachAddressHasABrokerAndRobotsKnowAllOfThem) {
    const Testbed testbed = parse_hosts(two_hosts, "hosts.toml");
    const KeptPrograms brokers = programs_of(testbed, testbed.hosts[0]);
    ASSERT_THAT(brokers.programs, SizeIs(2));
    EXPECT_EQ(brokers.programs[0].name, "pi1");
    EXPECT_EQ(brokers.programs[1].name, "pi1-2");
    EXPECT_THAT(brokers.programs[1].arguments, Contains("[fd00::1]:1883"));
    EXPECT_THAT(brokers.programs[1].arguments, Contains("wifi"));
    const KeptPrograms robots = programs_of(testbed, testbed.hosts[1]);
    ASSERT_THAT(robots.programs, SizeIs(1));
    EXPECT_THAT(robots.programs[0].arguments,
                ElementsAre("--count", "3", "--broker", "192.168.1.101:1883", "--broker",
                            "[fd00::1]:1883"));
}

}  // namespace
}  // namespace romano::experiments::hosts_file_test
