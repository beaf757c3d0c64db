#include "broker/daemon/default_name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "broker/net/endpoint_text.h"

namespace romano::daemon::default_name_test {
namespace {

Endpoint at(const char* text) {
    return *net::parse_endpoint(text);
}

TEST(DefaultName, TellsMachinesOfOneHostNameApartThatServeAllTheirAddresses) {
    EXPECT_EQ(default_name("pi", at("0.0.0.0:1883"), "b827eb000001"), "pi-b827eb000001:1883");
    EXPECT_EQ(default_name("pi", at("[::]:1884"), "b827eb000002"), "pi-b827eb000002:1884");
}

TEST(DefaultName, OfOneAddressIsThatAddress) {
    EXPECT_EQ(default_name("pi", at("127.0.0.1:1883"), "b827eb000001"), "pi-127.0.0.1:1883");
    EXPECT_EQ(default_name("pi", at("0.0.0.0:1883"), ""), "pi-0.0.0.0:1883");
}

TEST(DefaultName, IsNeverTooLong) {
    const std::string host(200, 'h');
    EXPECT_EQ(default_name(host, at("0.0.0.0:1883"), "b827eb000001").size(), longest_name);
    EXPECT_EQ(default_name(host, at("[::1]:1883"), "").size(), longest_name);
}

TEST(DefaultName, TakesTheHardwareAddressOfAnInterfaceThatThereIs) {
    std::vector<std::string> there = {""};  // a machine with nothing but its loopback
    for (const auto& interface : std::filesystem::directory_iterator("/sys/class/net")) {
        std::string address;
        std::ifstream(interface.path() / "address") >> address;
        std::erase(address, ':');
        there.push_back(address);
    }
    EXPECT_THAT(there, testing::Contains(hardware_address()));
    EXPECT_NE(hardware_address(), "000000000000");
}

}  // namespace
}  // namespace romano::daemon::default_name_test
