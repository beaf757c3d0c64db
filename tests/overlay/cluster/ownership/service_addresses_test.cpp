#include "overlay/cluster/ownership/service_addresses.h"

#include <gtest/gtest.h>

#include "tests/overlay/cluster/two_brokers.h"

namespace romano::cluster::service_addresses_test {
namespace {

using namespace two_brokers;

/// "self" has inherited the peer's address, which its machine does not serve.
struct ServiceAddressesTest : testing::Test {
    ServiceAddressesTest() {
        Effects acting = owner.effects();
        addresses.inherit(acting, theirs);
        addresses.on_address(theirs, false);
        owner.local.clear();
    }
    /// It is tried again.
    [[nodiscard]] bool seeks(bool is_held) {
        Effects acting = owner.effects();
        addresses.seek(acting, [&](const Endpoint&) { return is_held; });
        addresses.on_address(theirs, false);
        return !std::exchange(owner.local, {}).empty();
    }

    Owner owner;
    ServiceAddresses addresses{{ours}};
};

TEST_F(ServiceAddressesTest, WhatCouldNotBeServedIsTriedAgain) {
    EXPECT_TRUE(seeks(false));
    EXPECT_TRUE(seeks(false));
}

// P1: the owner was silent for a beacon whenever we tried, for we said then that we serve it.
TEST_F(ServiceAddressesTest, P1_WhatItsOwnerServesAgainIsSoughtNoMore) {
    EXPECT_FALSE(seeks(true));
    EXPECT_FALSE(seeks(false)) << "whoever inherits it next is told so";
}

TEST_F(ServiceAddressesTest, WhoBeginsAnewSeeksNothing) {
    Effects acting = owner.effects();
    addresses.give_up_all(acting);
    owner.local.clear();
    EXPECT_FALSE(seeks(false));
}

}  // namespace
}  // namespace romano::cluster::service_addresses_test
