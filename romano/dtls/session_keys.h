// The keys that OpenSSL agreed on (RFC 5246 section 6.3), for who opens and seals records without
// it.
#pragma once

#include <cstdint>
#include <optional>

#include "romano/dtls/record/record_cipher.h"

struct ssl_st;

namespace romano::dtls {

struct SessionKeys {
    RecordKeys keys;
    std::uint64_t rest = 0;  // eight octets more of the key expansion, which are no keys
};

/// Nothing before both ends have what they are made of, which is before the first Finished, or with
/// a suite that we do not know.
[[nodiscard]] std::optional<SessionKeys> session_keys(const ssl_st* ssl);

}  // namespace romano::dtls
