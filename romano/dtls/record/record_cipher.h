// Opens and seals protected records of epoch 1: AES-128-CCM-8 (RFC 6655; the cipher of protected
// packets) and AES-128-GCM (RFC 5288) of libcrypto; with a Connection ID as RFC 9146 section 5 has
// it. One of these serves all associations of a broker, which keep nothing but their keys:
// libcrypto's contexts are larger than what is to be kept of an association.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "romano/base/bytes.h"
#include "romano/dtls/record/connection_id.h"
#include "romano/dtls/record/record.h"

struct evp_cipher_ctx_st;

namespace romano::dtls {

enum class Suite : std::uint8_t { aes_128_ccm_8, aes_128_gcm };
inline constexpr std::size_t known_suites = 2;

/// Of one direction. RFC 5288 section 3 calls the four octets the salt.
struct WriteKey {
    std::array<std::uint8_t, 16> key{};
    std::array<std::uint8_t, 4> salt{};

    friend bool operator==(const WriteKey&, const WriteKey&) = default;
};

struct RecordKeys {
    Suite suite = Suite::aes_128_ccm_8;
    WriteKey client;
    WriteKey server;

    friend bool operator==(const RecordKeys&, const RecordKeys&) = default;
};

[[nodiscard]] constexpr std::size_t tag_octets(Suite suite) {
    return suite == Suite::aes_128_ccm_8 ? 8 : 16;
}
/// In front of the ciphertext: the eight octets of the nonce that are not the salt.
inline constexpr std::size_t explicit_nonce_octets = 8;
/// What a record is longer than its message, header included. With a Connection ID the message
/// takes its type along.
[[nodiscard]] constexpr std::size_t overhead(Suite suite, std::size_t id_octets = 0) {
    return header_octets + id_octets + explicit_nonce_octets + (id_octets == 0 ? 0 : 1) +
           tag_octets(suite);
}
inline constexpr std::size_t most_overhead =
    overhead(Suite::aes_128_gcm, ConnectionId::most_octets);
/// RFC 6347 section 4.1: a record's plaintext.
inline constexpr std::size_t most_message = 1U << 14U;

/// What was in a record.
struct Opened {
    ContentType type = ContentType::alert;
    std::size_t size = 0;
};

class RecordCipher {
public:
    RecordCipher();
    ~RecordCipher();

    /// A whole record with this number, which has 48 bits and was never used under this key: the
    /// nonce is the number. `id` is its receiver's; empty: none. Returns its size, 0 when the
    /// message is empty or too long, or `out` too small.
    [[nodiscard]] std::size_t seal(Suite suite, const WriteKey& key, ContentType type,
                                   std::uint64_t number, Bytes message, MutableBytes out,
                                   Bytes id = {});

    /// The message in `out`; nothing when the record is not of this key, or `out` is too small.
    /// With a Connection ID it may be empty.
    [[nodiscard]] std::optional<Opened> open(Suite suite, const WriteKey& key, const Record& record,
                                             MutableBytes out);

private:
    struct FreeContext {
        void operator()(evp_cipher_ctx_st* context) const;
    };
    using Context = std::unique_ptr<evp_cipher_ctx_st, FreeContext>;

    [[nodiscard]] static Context gcm(bool seals);

    Context sealing_;  // of GCM
    Context opening_;
};

}  // namespace romano::dtls
