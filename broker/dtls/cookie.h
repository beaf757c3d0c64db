// The cookie of an address (RFC 6347 section 4.2.1): who does not say it in its ClientHello is told
// it by a HelloVerifyRequest, and forgotten.
//
// OpenSSL can do that, too. It takes several times as long, and whoever floods a broker with
// ClientHellos would have that time of it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "broker/dtls/association.h"
#include "romano/base/bytes.h"
#include "romano/dtls/record/record.h"
#include "romano/protection/keys.h"

namespace romano::dtls {

/// RFC 5246 section 7.4.1.2 and RFC 6347 section 4.2.1: what is in front of the suites.
struct ClientHello {
    std::array<std::uint8_t, 32> random{};
    Bytes cookie{};  // empty in the first one
};

/// Nothing when the record is of something else, or is not the beginning of one with a whole
/// cookie.
[[nodiscard]] std::optional<ClientHello> client_hello_in(const Record& record);

using Cookie = std::array<std::uint8_t, 16>;

/// `key` is random, each process has its own, and nothing else is done with it.
[[nodiscard]] Cookie cookie_of(const protection::Key& key, const Path& path);

inline constexpr std::size_t verify_request_octets = header_octets + 12 + 3 + 16;

/// Writes the HelloVerifyRequest that answers `hello`, which is never shorter, to `out` of
/// verify_request_octets.
void put_verify_request(const Record& hello, const Cookie& cookie, MutableBytes out);

}  // namespace romano::dtls
