// Cookies of addresses, octet by octet (RFC 6347 sections 4.2.1 and 4.3.2).

#include "broker/dtls/cookie.h"

#include <gtest/gtest.h>

#include <vector>

namespace romano::dtls::cookie_test {
namespace {

using Octets = std::vector<std::uint8_t>;

constexpr protection::Key key{0x5E};
constexpr std::size_t body_at = header_octets;

/// With a session's id of two octets; its record has the number 7.
Octets hello_with(const Octets& cookie) {
    Octets message{0xFE, 0xFD};
    for (std::uint8_t n = 1; n <= 32; ++n) message.push_back(n);
    message.insert(message.end(), {2, 0xA, 0xB, static_cast<std::uint8_t>(cookie.size())});
    message.insert(message.end(), cookie.begin(), cookie.end());
    message.insert(message.end(), {0, 2, 0xC0, 0xA8, 1, 0});
    const auto size = static_cast<std::uint8_t>(message.size());
    Octets out{22, 0xFE, 0xFF, 0, 0, 0, 0, 0, 0, 0, 7, 0, static_cast<std::uint8_t>(12 + size)};
    out.insert(out.end(), {1, 0, 0, size, 0, 0, 0, 0, 0, 0, 0, size});
    out.insert(out.end(), message.begin(), message.end());
    return out;
}

std::optional<ClientHello> read(const Octets& datagram) {
    const auto record = first_record(datagram);
    return record ? client_hello_in(*record) : std::nullopt;
}

Path path() {
    const Endpoint via{.address = {127, 0, 0, 1}, .port = 8883, .family = Endpoint::Family::ipv4};
    Endpoint from = via;
    from.port = 5000;
    return {via, from};
}

TEST(ADtlsCookie, StandsBehindTheSessionOfAClientHello) {
    const Octets datagram = hello_with({7, 8, 9});  // into which the cookie is a view
    const auto hello = read(datagram);
    ASSERT_TRUE(hello);
    EXPECT_EQ(hello->random[0], 1);
    EXPECT_EQ(hello->random[31], 32);
    EXPECT_EQ(Octets(hello->cookie.begin(), hello->cookie.end()), (Octets{7, 8, 9}));
    EXPECT_TRUE(read(hello_with({}))->cookie.empty());
}

TEST(ADtlsCookie, IsNotReadOfWhatIsNoBeginningOfAClientHello) {
    const Octets whole = hello_with({7, 8, 9});
    const auto with = [&](std::size_t at, std::uint8_t octet) {
        Octets changed = whole;
        changed[at] = octet;
        return read(changed).has_value();
    };
    EXPECT_TRUE(with(body_at + 5, 1)) << "its number may be another";
    EXPECT_FALSE(with(0, 21)) << "an alert";
    EXPECT_FALSE(with(4, 1)) << "another epoch";
    EXPECT_FALSE(with(body_at, 2)) << "a ServerHello";
    EXPECT_FALSE(with(body_at + 8, 1)) << "a later fragment";
    EXPECT_FALSE(with(body_at + 11, 200)) << "a fragment that goes on behind the record";
    EXPECT_FALSE(with(body_at + 3, 10)) << "a fragment longer than the message";
    EXPECT_FALSE(with(body_at + 12 + 34, 200)) << "a session's id that goes on behind it";
    EXPECT_FALSE(with(body_at + 12 + 37, 200)) << "a cookie that does";
}

TEST(ADtlsCookie, IsReadOfAFragmentThatHasAllOfIt) {
    const Octets whole = hello_with({7, 8, 9});
    const std::size_t behind_cookie = body_at + 12 + 38 + 3;
    for (std::size_t size = body_at + 12; size <= whole.size(); ++size) {
        Octets cut{whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)};
        cut[12] = static_cast<std::uint8_t>(size - body_at);
        cut[body_at + 11] = static_cast<std::uint8_t>(size - body_at - 12);
        EXPECT_EQ(read(cut).has_value(), size >= behind_cookie) << size;
    }
}

TEST(ADtlsCookie, IsAskedForAsRfc6347SaysAndInNoMoreOctetsThanAnyHello) {
    const Octets hello = hello_with({});
    const Cookie cookie{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    Octets request(verify_request_octets);
    put_verify_request(*first_record(hello), cookie, request);
    EXPECT_EQ(request,
              (Octets{22,   0xFE, 0xFF, 0,  0, 0, 0, 0, 0, 0, 7, 0,  31,  // the hello's number
                      3,    0,    0,    19, 0, 0, 0, 0, 0, 0, 0, 19,      // one fragment
                      0xFE, 0xFF, 16,   1,  2, 3, 4, 5, 6, 7, 8, 9,  10, 11, 12, 13, 14, 15, 16}));
    constexpr std::size_t shortest_hello = body_at + 12 + 2 + 32 + 1 + 1;
    EXPECT_LE(verify_request_octets, shortest_hello);
}

TEST(ADtlsCookie, IsAnotherForEachAddressAndEachProcess) {
    std::vector<Path> others(5, path());
    others[0].from.port ^= 1U;
    others[1].from.address[3] ^= 1U;
    others[2].from.scope = 2;
    others[3].from.family = Endpoint::Family::ipv6;
    others[4].via.port ^= 1U;
    const Cookie own = cookie_of(key, path());
    EXPECT_EQ(cookie_of(key, path()), own);
    for (const Path& other : others) EXPECT_NE(cookie_of(key, other), own);
    EXPECT_NE(cookie_of({0x5F}, path()), own);
}

}  // namespace
}  // namespace romano::dtls::cookie_test
