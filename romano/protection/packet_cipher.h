// What packets are sealed by: AES-CCM with a tag of 64 bits, and nonce_of() the header. There are
// two of it, which make the same octets, and a program has one: packet_cipher.cpp with our own AES
// and SHA-256, small, for chips; libcrypto/packet_cipher.cpp with those of libcrypto, which uses
// the processor's instructions, for computers.
#pragma once

#include "romano/base/bytes.h"
#include "romano/protection/keys.h"
#include "romano/protection/packet.h"

namespace romano::protection {

/// Encrypts `message`, which is not empty, where it lies, and writes `tag`.
void seal(const Key& key, Bytes header, MutableBytes message, MutableBytes tag);

/// Decrypts `message` where it lies. False when the tag is wrong; `message` is then zeros.
[[nodiscard]] bool open(const Key& key, Bytes header, MutableBytes message, Bytes tag);

}  // namespace romano::protection
