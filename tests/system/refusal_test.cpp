// A setting that is not possible: one sentence on stderr, exit code 2, nothing on stdout.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"

namespace romano::system::refusal_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// What it said; checks the rest.
std::string refusal(const std::vector<std::string>& arguments) {
    BrokerProcess broker(arguments);
    EXPECT_EQ(broker.wait_for_exit(), 2);
    EXPECT_EQ(broker.next_line(), "") << "stdout is for a broker that serves";
    std::string errors = broker.errors();
    EXPECT_EQ(std::ranges::count(errors, '\n'), 1) << errors;
    EXPECT_THAT(errors, StartsWith("romano-broker: "));
    return errors;
}

TEST(Refusal, NamesTheSettingAndTheValue) {
    const std::vector<std::vector<std::string>> cases = {{"--listen", "127.0.0.1"},
                                                         {"--listen", "10.255.255.1:1883"},
                                                         {"--domain", "231"},
                                                         {"--interface", "no-such"},
                                                         {"--elector", "dice"},
                                                         {"--detector", "oracle"},
                                                         {"--predefined", "0=a"},
                                                         {"--rank", "high"},
                                                         {"--acks", "most"},
                                                         {"--beacon-ms", "0"},
                                                         {"--detection-timeout-ms", "1"},
                                                         {"--gateway-id", "999"},
                                                         {"--config", "/no/such/file"},
                                                         {"--log-level", "loud"},
                                                         {"--discovery-group", "1.2.3.4:5"},
                                                         {"--cell-group", "1.2.3.4:5"}};
    for (const auto& arguments : cases) {
        auto with_address = arguments;
        with_address.emplace_back("--allow-plain");
        if (arguments[0] != "--listen") {
            with_address.insert(with_address.end(), {"--listen", "127.77.0.1:0"});
        }
        if (arguments[0] == "--interface")
            with_address.insert(with_address.end(), {"--domain", "7"});
        EXPECT_THAT(refusal(with_address),
                    AllOf(HasSubstr(arguments[0]), HasSubstr("'" + arguments[1] + "'")));
    }
}

TEST(Refusal, OfAPlainAddressThatOthersReachUnlessItIsAllowedInPlainWords) {
    for (const std::string address : {"10.255.255.1:1883", "0.0.0.0:0", "[::]:0"}) {
        EXPECT_THAT(refusal({"--listen", "127.77.0.1:0", "--listen", address}),
                    AllOf(HasSubstr("--listen '" + address + "': is plain"),
                          HasSubstr("--allow-plain"), HasSubstr("protected://" + address)));
    }
}

TEST(Refusal, OfAnUnknownKeyOfTheConfigurationFile) {
    const std::string path =
        testing::TempDir() + "romano-bad-" + std::to_string(getpid()) + ".toml";
    std::ofstream(path) << "name = \"r1\"\nbananas = 3\n";
    EXPECT_THAT(refusal({"--config", path}), AllOf(HasSubstr(path), HasSubstr("'bananas'")));
    unlink(path.c_str());
}

TEST(Refusal, OfAPortThatIsInUse) {
    const TestAddresses addresses;
    BrokerProcess first({"--listen", addresses.service(1)});
    first.wait_until_serving();
    EXPECT_THAT(refusal({"--listen", addresses.service(1)}),
                AllOf(HasSubstr("'" + addresses.service(1) + "'"), HasSubstr("in use")));
}

TEST(Refusal, OfAnAddressThatIsAnotherBrokersByConfiguration) {
    const TestAddresses addresses;
    const std::vector<std::string> cluster = {"--domain",    std::to_string(addresses.domain()),
                                              "--interface", "lo",
                                              "--listen",    addresses.service(1)};
    auto arguments = cluster;
    arguments.insert(arguments.end(), {"--name", "r1"});
    BrokerProcess first(arguments);
    first.wait_until_serving();
    arguments = cluster;
    arguments.insert(arguments.end(), {"--name", "r2"});
    EXPECT_THAT(refusal(arguments),
                AllOf(HasSubstr("'" + addresses.service(1) + "'"), HasSubstr("broker r1 listens")));
}

TEST(Refusal, OfAPortThatAStrangerToTheClusterHas) {
    const TestAddresses addresses;
    BrokerProcess stranger({"--listen", addresses.service(1)});
    stranger.wait_until_serving();
    EXPECT_THAT(refusal({"--listen", addresses.service(1), "--domain",
                         std::to_string(addresses.domain()), "--interface", "lo"}),
                AllOf(HasSubstr("'" + addresses.service(1) + "'"), HasSubstr("in use")));
}

// DDS would abort at the first descriptor that select() cannot wait for.
TEST(Refusal, OfABrokerThatInheritsTheDescriptorsThatDdsNeeds) {
    std::string script = "for fd in $(seq 10 1100); do eval \"exec $fd</dev/null\"; done; exec ";
    script += ROMANO_BROKER " --listen 127.77.0.1:0 --domain 7 --interface lo";
    Process broker("/bin/bash", {"-c", script});
    EXPECT_EQ(broker.wait_for_exit(), 2);
    EXPECT_THAT(broker.errors(),
                HasSubstr(" of the file descriptors below 1024 are open, inherited from what "
                          "started this broker, and DDS needs 64 of them"));
}

TEST(Help, AndVersionEndWithSuccess) {
    BrokerProcess help({"--help"});
    EXPECT_EQ(help.wait_for_exit(), 0);
    EXPECT_THAT(help.next_line(), HasSubstr("MQTT-SN"));
    BrokerProcess version({"--version"});
    EXPECT_EQ(version.wait_for_exit(), 0);
    EXPECT_THAT(version.next_line(), StartsWith("romano-broker "));
}

}  // namespace
}  // namespace romano::system::refusal_test
