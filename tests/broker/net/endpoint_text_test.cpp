#include "broker/net/endpoint_text.h"

#include <gtest/gtest.h>

#include "broker/net/socket_address.h"

namespace romano::net::endpoint_text_test {
namespace {

TEST(EndpointText, ReadsIpv4) {
    const auto endpoint = parse_endpoint("127.0.0.1:1883");
    ASSERT_TRUE(endpoint);
    EXPECT_EQ(endpoint->family, Endpoint::Family::ipv4);
    EXPECT_EQ(endpoint->port, 1883);
    EXPECT_EQ(endpoint->address[0], 127);
    EXPECT_EQ(endpoint->address[3], 1);
}

TEST(EndpointText, ReadsIpv6InBrackets) {
    const auto endpoint = parse_endpoint("[::1]:1883");
    ASSERT_TRUE(endpoint);
    EXPECT_EQ(endpoint->family, Endpoint::Family::ipv6);
    EXPECT_EQ(endpoint->address[15], 1);
}

TEST(EndpointText, ReadsTheInterfaceOfALinkLocalAddress) {
    const auto endpoint = parse_endpoint("[fe80::1%lo]:1883");
    ASSERT_TRUE(endpoint);
    EXPECT_NE(endpoint->scope, 0U);
    EXPECT_EQ(to_text(*endpoint), "[fe80::1%lo]:1883");
}

TEST(EndpointText, WritesWhatItReads) {
    for (const char* text : {"0.0.0.0:1", "127.77.1.2:65535", "[::]:1883", "[2001:db8::7]:5"}) {
        const auto endpoint = parse_endpoint(text);
        ASSERT_TRUE(endpoint) << text;
        EXPECT_EQ(to_text(*endpoint), text);
    }
}

TEST(EndpointText, RefusesWhatIsNoAddressAndPort) {
    for (const char* text : {"", ":", "127.0.0.1", "127.0.0.1:", ":1883", "127.0.0.1:65536",
                             "127.0.0.1:-1", "127.0.0.1:18x", "127.0.0:1883", "256.0.0.1:1",
                             "localhost:1883", "::1:1883", "[::1]", "[::1:1883", "[127.0.0.1]:1",
                             "[fe80::1%no-such-interface]:1", "127.0.0.1 :1", "127.0.0.1:1 "}) {
        EXPECT_FALSE(parse_endpoint(text)) << text;
    }
}

TEST(EndpointText, AServiceAddressSaysHowItsClientsSpeak) {
    for (const char* text : {"protected://127.0.0.1:1883", "protected://[::1]:1883"}) {
        const auto address = parse_service_address(text);
        ASSERT_TRUE(address) << text;
        EXPECT_EQ(address->packets, Endpoint::Packets::sealed);
        EXPECT_EQ(to_text(*address), text);
        EXPECT_FALSE(parse_endpoint(text)) << "where only an address is wanted";
    }
    EXPECT_EQ(parse_service_address("127.0.0.1:1"), parse_endpoint("127.0.0.1:1"));
    EXPECT_FALSE(parse_service_address("protected://127.0.0.1"));
    EXPECT_FALSE(parse_service_address("other://127.0.0.1:1"));
}

TEST(SocketAddress, KeepsAnEndpoint) {
    for (const char* text : {"127.77.1.2:65535", "[2001:db8::7]:5", "[fe80::1%lo]:1883"}) {
        const Endpoint endpoint = *parse_endpoint(text);
        EXPECT_EQ(to_endpoint(to_socket_address(endpoint)), endpoint) << text;
    }
}

TEST(SocketAddress, KnowsWildcardsAndGroups) {
    EXPECT_TRUE(is_wildcard(*parse_endpoint("0.0.0.0:1883")));
    EXPECT_TRUE(is_wildcard(*parse_endpoint("[::]:1883")));
    EXPECT_FALSE(is_wildcard(*parse_endpoint("127.0.0.1:1883")));
    for (const auto& [served, reached] :
         {std::pair{"0.0.0.0:1883", "127.0.0.1:1883"}, std::pair{"[::]:7", "[::1]:7"},
          std::pair{"192.0.2.1:1883", "192.0.2.1:1883"}}) {
        EXPECT_EQ(to_text(as_reached_here(*parse_endpoint(served))), reached);
    }
    EXPECT_TRUE(is_multicast(*parse_endpoint("225.1.1.1:1883")));
    EXPECT_TRUE(is_multicast(*parse_endpoint("[ff02::1]:1883")));
    EXPECT_FALSE(is_multicast(*parse_endpoint("192.168.0.1:1883")));
}

}  // namespace
}  // namespace romano::net::endpoint_text_test
