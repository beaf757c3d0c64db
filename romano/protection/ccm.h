// AES-CCM (RFC 3610, NIST SP 800-38C): a message is encrypted and, with octets that stay readable,
// authenticated.
//
// The nonce has 7 to 13 octets, the tag an even number from 4 to 16; there are readable octets,
// fewer than 65,280; the message fits the length field that the nonce leaves room for. Two messages
// under one key and nonce give their contents away, and the means to forge others.
#pragma once

#include <cstddef>
#include <cstdint>

#include "romano/base/bytes.h"
#include "romano/protection/aes.h"
#include "romano/protection/keys.h"

namespace romano::protection {

/// For one message. The key outlives it.
class Ccm {
public:
    Ccm(const Key& key, Bytes nonce);

    /// Encrypts `message` where it lies, and writes `tag`.
    void seal(Bytes readable, MutableBytes message, MutableBytes tag) const;

    /// Decrypts `message` where it lies. False when the tag is wrong; `message` is then zeros.
    [[nodiscard]] bool open(Bytes readable, MutableBytes message, Bytes tag) const;

private:
    [[nodiscard]] Block block(std::uint8_t flags, std::size_t number) const;
    [[nodiscard]] Block tag_block(Bytes readable, Bytes message, std::size_t tag_octets) const;
    void add_key_stream(std::size_t from, MutableBytes octets) const;

    const Key& key_;
    Block numbered_;  // A_0 of RFC 3610 section 2.3
};

}  // namespace romano::protection
