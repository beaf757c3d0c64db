// MQTT-SN 1.2 section 6.1: a client finds its gateways.

#include "romano/client/discovery.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <vector>

#include "romano/mqttsn/codec.h"

namespace romano::client::discovery_test {
namespace {

using namespace mqttsn;
using namespace std::chrono_literals;
using Octets = std::vector<std::uint8_t>;

Endpoint endpoint(std::uint8_t last, std::uint16_t port = 1883) {
    Endpoint e;
    e.family = Endpoint::Family::ipv4;
    e.address = {10, 0, 0, last};
    e.port = port;
    return e;
}

class DiscoveryTest : public testing::Test {
protected:
    void gets(const Endpoint& from, const Message& message) {
        Octets octets(encoded_size(message));
        EXPECT_EQ(encode(message, octets), octets.size());
        discovery.on_datagram(now, from, octets);
    }
    void after(Duration time) {
        const Instant end = now + time;
        for (int steps = 0; discovery.next_wakeup() <= end; ++steps) {
            ASSERT_LT(steps, 1000);
            now = std::max(now, discovery.next_wakeup());
            Octets octets(Discovery::largest_datagram);
            octets.resize(discovery.on_tick(now, octets));
            if (!octets.empty()) sent.push_back({now, octets});
        }
        now = end;
    }

    struct Sent {
        Instant at;
        Octets octets;
    };
    Discovery discovery{{}, 1};
    Instant now{};
    std::vector<Sent> sent;
    const Octets searchgw{0x03, 0x01, 0x00};
};

TEST_F(DiscoveryTest, NotesAGatewayThatAdvertises) {  // 6.1c
    gets(endpoint(1), Advertise{7, 900});
    ASSERT_EQ(discovery.gateways().size(), 1u);
    EXPECT_EQ(discovery.gateways()[0].id, 7);
    EXPECT_EQ(discovery.gateways()[0].address, endpoint(1));
}

TEST_F(DiscoveryTest, ForgetsAGatewayAfterNadvMissedAdvertises) {
    gets(endpoint(1), Advertise{7, 900});
    after(900s);
    gets(endpoint(1), Advertise{7, 900});
    after(2699s);
    EXPECT_EQ(discovery.gateways().size(), 1u);
    after(1s);
    EXPECT_TRUE(discovery.gateways().empty());
    EXPECT_EQ(discovery.next_wakeup(), never);
}

TEST_F(DiscoveryTest, FollowsAGatewayToANewAddress) {
    gets(endpoint(1), Advertise{7, 900});
    gets(endpoint(2), Advertise{7, 900});
    ASSERT_EQ(discovery.gateways().size(), 1u);
    EXPECT_EQ(discovery.gateways()[0].address, endpoint(2));
}

TEST_F(DiscoveryTest, SearchesWithinTsearchgwThenEverMoreRarely) {  // 6.1d
    discovery.search(now);
    after(5s);
    ASSERT_EQ(sent.size(), 1u);
    EXPECT_EQ(sent[0].octets, searchgw);
    after(60s);
    ASSERT_EQ(sent.size(), 4u);
    EXPECT_EQ(sent[1].at - sent[0].at, 5s);
    EXPECT_EQ(sent[2].at - sent[1].at, 10s);
    EXPECT_EQ(sent[3].at - sent[2].at, 20s);
}

TEST_F(DiscoveryTest, EndsItsSearchWithTheFirstGateway) {
    discovery.search(now);
    after(5s);
    gets(endpoint(1), Gwinfo{7, {}});
    EXPECT_FALSE(discovery.is_searching());
    after(600s);
    EXPECT_EQ(sent.size(), 1u);
    ASSERT_EQ(discovery.gateways().size(), 1u);
    EXPECT_EQ(discovery.gateways()[0].address, endpoint(1));
}

TEST_F(DiscoveryTest, TakesAnotherClientsEqualSearchForItsOwn) {  // 6.1d
    discovery.search(now);
    gets(endpoint(9), Searchgw{0});
    const Instant heard = now;
    after(6s);
    ASSERT_EQ(sent.size(), 1u);
    EXPECT_EQ(sent[0].at - heard, 5s);
}

TEST_F(DiscoveryTest, BelievesAnotherClientAboutAnUnknownGatewayOnly) {  // 6.1c
    const Octets address{10, 0, 0, 3, 0x27, 0x10};
    gets(endpoint(9), Gwinfo{7, address});
    ASSERT_EQ(discovery.gateways().size(), 1u);
    EXPECT_EQ(discovery.gateways()[0].address, endpoint(3, 10000));
    gets(endpoint(1), Advertise{7, 900});
    gets(endpoint(9), Gwinfo{7, address});
    EXPECT_EQ(discovery.gateways()[0].address, endpoint(1));
}

TEST_F(DiscoveryTest, ReadsEveryFormOfAGatewaysAddress) {  // 5.3.5, G4
    const std::vector<std::pair<Octets, Endpoint>> forms = {
        {{10, 0, 0, 3}, endpoint(3)},
        {{4, 10, 0, 0, 3}, endpoint(3)},
        {{10, 0, 0, 3, 0x27, 0x10}, endpoint(3, 10000)},
        {{6, 10, 0, 0, 3, 0x27, 0x10}, endpoint(3, 10000)},
    };
    const auto read = [this](const Octets& octets) {
        Discovery fresh({}, 1);
        const Message gwinfo = Gwinfo{1, octets};
        Octets datagram(encoded_size(gwinfo));
        EXPECT_EQ(encode(gwinfo, datagram), datagram.size());
        fresh.on_datagram(now, endpoint(9), datagram);
        return fresh.gateways().empty() ? Endpoint{} : fresh.gateways()[0].address;
    };
    for (const auto& [octets, expected] : forms) EXPECT_EQ(read(octets), expected);
    for (const std::size_t size : {16u, 17u, 18u, 19u}) {
        const Endpoint address = read(Octets(size, 0xFE));
        EXPECT_EQ(address.family, Endpoint::Family::ipv6);
        EXPECT_EQ(address.port, size < 18 ? 1883 : 0xFEFE);
    }
}

TEST_F(DiscoveryTest, IgnoresAnAddressOfNoKnownForm) {
    for (const std::size_t size : {1u, 2u, 3u, 8u, 15u, 20u, 21u}) {
        gets(endpoint(9), Gwinfo{7, Octets(size)});
    }
    EXPECT_TRUE(discovery.gateways().empty());
}

TEST_F(DiscoveryTest, NotesAsManyGatewaysAsItHoldsAndNoMore) {  // P8
    for (std::uint8_t id = 0; id < 10; ++id) gets(endpoint(id), Advertise{id, 900});
    EXPECT_EQ(discovery.gateways().size(), Discovery::most_gateways);
}

}  // namespace
}  // namespace romano::client::discovery_test
