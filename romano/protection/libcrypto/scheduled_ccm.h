// AES-CCM (RFC 3610, as in ccm.h) for computers, with the key scheduled once.
//
// libcrypto has CCM, too; but it is told key, nonce and lengths anew for each packet, which takes
// more than twice as long as the cryptography of a short one. So the mode is ours and AES is
// libcrypto's: one call for the tag, one for the key stream.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "romano/base/bytes.h"
#include "romano/protection/aes.h"
#include "romano/protection/keys.h"

struct evp_cipher_ctx_st;

namespace romano::protection {

class ScheduledCcm {
public:
    explicit ScheduledCcm(const Key& key);

    /// Of this thread, and of this key until the next call. 256 keys stay scheduled, each in the
    /// place that its first octet names: keys are random. 1.4 KB each.
    [[nodiscard]] static ScheduledCcm& of(const Key& key);

    /// Sizes and what they mean: as in ccm.h.
    void seal(Bytes nonce, Bytes readable, MutableBytes message, MutableBytes tag);
    [[nodiscard]] bool open(Bytes nonce, Bytes readable, MutableBytes message, Bytes tag);

private:
    struct Free {
        void operator()(evp_cipher_ctx_st* context) const;
    };
    using Context = std::unique_ptr<evp_cipher_ctx_st, Free>;

    class Mac;

    void schedule(const Key& key);
    [[nodiscard]] Block tag_block(Bytes nonce, Bytes readable, Bytes message,
                                  std::size_t tag_octets);
    /// The first block of the key stream; those behind it go over the message.
    Block add_key_stream(Bytes nonce, MutableBytes message);

    Key key_{};
    Context blocks_;  // ECB: block by block
    Context chain_;   // CBC
    Block last_{};    // what the chain's next block is added to
};

}  // namespace romano::protection
