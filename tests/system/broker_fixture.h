// A test with real brokers at addresses of its own: r1, r2, ..., each alone or members of a
// cluster.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"

namespace romano::system {

struct BrokerFixture : testing::Test {
    BrokerProcess& start_broker(int n, std::vector<std::string> more = {}) {
        std::vector<std::string> arguments{"--listen", addresses.service(n), "--name",
                                           "r" + std::to_string(n)};
        arguments.insert(arguments.end(), more.begin(), more.end());
        auto broker = std::make_unique<BrokerProcess>(arguments);
        broker->wait_until_serving();
        brokers.push_back(std::move(broker));
        return *brokers.back();
    }
    BrokerProcess& start_member(int n, std::vector<std::string> more = {}) {
        more.insert(more.end(),
                    {"--domain", std::to_string(addresses.domain()), "--interface", "lo", "--rank",
                     std::to_string(n), "--detection-timeout-ms", "300"});
        return start_broker(n, std::move(more));
    }

    TestAddresses addresses;
    std::vector<std::unique_ptr<BrokerProcess>> brokers;
};

}  // namespace romano::system
