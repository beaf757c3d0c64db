#include "broker/dtls/cookie.h"

#include <algorithm>

#include "romano/protection/libcrypto/scheduled_ccm.h"

namespace romano::dtls {
namespace {

// RFC 6347 section 4.3.2.
constexpr std::uint8_t client_hello = 1;
constexpr std::uint8_t hello_verify_request = 3;
constexpr std::size_t handshake_header = 12;
constexpr std::size_t random_at = handshake_header + 2;
constexpr std::size_t session_at = random_at + 32;
// Section 4.2.1: whichever version will be agreed on, the request is of 1.0.
constexpr std::uint16_t version_1_0 = 0xFEFF;

std::size_t be24(Bytes octets, std::size_t at) {
    return std::size_t{octets[at]} << 16U | be16(octets, at + 1);
}

/// A field whose first octet is its size; nothing when it is not whole.
std::optional<Bytes> sized_field(Bytes body, std::size_t at) {
    if (at >= body.size() || body.size() - at - 1 < body[at]) return std::nullopt;
    return body.subspan(at + 1, body[at]);
}

}  // namespace

std::optional<ClientHello> client_hello_in(const Record& record) {
    const Bytes body = record.body;
    if (record.type != ContentType::handshake || record.epoch != 0 || body.size() <= session_at ||
        body[0] != client_hello) {
        return std::nullopt;
    }
    const std::size_t fragment_at = be24(body, 6);
    const std::size_t fragment_octets = be24(body, 9);
    if (fragment_at != 0 || fragment_octets != body.size() - handshake_header ||
        fragment_octets > be24(body, 1)) {
        return std::nullopt;
    }
    const auto session = sized_field(body, session_at);
    if (!session) return std::nullopt;
    const auto cookie = sized_field(body, session_at + 1 + session->size());
    if (!cookie) return std::nullopt;
    ClientHello hello{.cookie = *cookie};
    std::ranges::copy(body.subspan(random_at, hello.random.size()), hello.random.begin());
    return hello;
}

Cookie cookie_of(const protection::Key& key, const Path& path) {
    constexpr std::size_t end_octets = 23;
    std::array<std::uint8_t, 2 * end_octets> whose{};
    std::size_t at = 0;
    for (const Endpoint& end : {path.from, path.via}) {
        std::copy(end.address.begin(), end.address.end(), whose.begin() + at);
        put_be16(whose, at + 16, end.port);
        whose[at + 18] = static_cast<std::uint8_t>(end.family);
        for (std::size_t i = 0; i < 4; ++i) {
            whose[at + 19 + i] = static_cast<std::uint8_t>(end.scope >> 8 * i);
        }
        at += end_octets;
    }
    // The tag of CCM over readable octets alone, as many each time, is a CBC-MAC. Nothing is
    // encrypted, so that one nonce does.
    constexpr std::array<std::uint8_t, 13> nonce{};
    Cookie cookie;
    protection::ScheduledCcm::of(key).seal(nonce, whose, {}, cookie);
    return cookie;
}

void put_verify_request(const Record& hello, const Cookie& cookie, MutableBytes out) {
    constexpr std::size_t body_octets = verify_request_octets - header_octets;
    constexpr auto message_octets = static_cast<std::uint8_t>(body_octets - handshake_header);
    put_header(out, ContentType::handshake, epoch_and_number(0, hello.number), {}, body_octets);
    put_be16(out, 1, version_1_0);
    const MutableBytes body = out.subspan(header_octets, body_octets);
    std::ranges::fill(body, std::uint8_t{0});  // number 0, from its first octet on
    body[0] = hello_verify_request;
    body[3] = message_octets;   // all that there is
    body[11] = message_octets;  // and this is all
    put_be16(body, handshake_header, version_1_0);
    body[handshake_header + 2] = static_cast<std::uint8_t>(cookie.size());
    std::ranges::copy(cookie, body.begin() + handshake_header + 3);
}

}  // namespace romano::dtls
