#include "romano/protection/libcrypto/scheduled_ccm.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <span>

namespace romano::protection {
namespace {

constexpr std::size_t block_size = std::tuple_size_v<Block>;
/// As many blocks as are encrypted by one call.
using Room = std::array<std::uint8_t, 16 * block_size>;

/// What goes wrong here is want of memory: no packet may leave half sealed.
void insist(bool is_done) {
    if (!is_done) std::abort();
}

/// Whole blocks, where they lie.
void encrypt(EVP_CIPHER_CTX* context, MutableBytes octets) {
    int done = 0;
    const auto size = static_cast<int>(octets.size());
    insist(EVP_EncryptUpdate(context, octets.data(), &done, octets.data(), size) == 1 &&
           done == size);
}

/// Into the end of a block, where there are zeros.
void put_number(std::size_t number, MutableBytes block) {
    for (std::size_t at = block_size - 1; number != 0; --at, number >>= 8U) {
        block[at] = static_cast<std::uint8_t>(number);
    }
}

/// RFC 3610 sections 2.2 and 2.3, B_0 and A_0: flags, nonce and, in the rest, a number.
Block block_of(std::size_t flags, Bytes nonce, std::size_t number) {
    Block made{static_cast<std::uint8_t>(flags | (14 - nonce.size()))};
    std::ranges::copy(nonce, made.begin() + 1);
    put_number(number, made);
    return made;
}

/// Eight octets at a time: by single ones a long message takes as long as its encryption.
void put_over(Bytes what, MutableBytes to) {
    std::size_t at = 0;
    for (std::uint64_t word = 0; at + sizeof word <= what.size(); at += sizeof word) {
        std::uint64_t under = 0;
        std::memcpy(&word, what.data() + at, sizeof word);
        std::memcpy(&under, to.data() + at, sizeof under);
        under ^= word;
        std::memcpy(to.data() + at, &under, sizeof under);
    }
    for (; at < what.size(); ++at) to[at] ^= what[at];
}

}  // namespace

void ScheduledCcm::Free::operator()(evp_cipher_ctx_st* context) const {
    EVP_CIPHER_CTX_free(context);
}

ScheduledCcm::ScheduledCcm(const Key& key)
    : blocks_(EVP_CIPHER_CTX_new()), chain_(EVP_CIPHER_CTX_new()) {
    insist(blocks_ && chain_ &&
           EVP_EncryptInit_ex(blocks_.get(), EVP_aes_128_ecb(), nullptr, nullptr, nullptr) == 1 &&
           EVP_EncryptInit_ex(chain_.get(), EVP_aes_128_cbc(), nullptr, nullptr, nullptr) == 1 &&
           EVP_CIPHER_CTX_set_padding(blocks_.get(), 0) == 1 &&
           EVP_CIPHER_CTX_set_padding(chain_.get(), 0) == 1);
    schedule(key);
}

void ScheduledCcm::schedule(const Key& key) {
    key_ = key;
    last_ = {};
    insist(EVP_EncryptInit_ex(blocks_.get(), nullptr, nullptr, key.data(), nullptr) == 1 &&
           EVP_EncryptInit_ex(chain_.get(), nullptr, nullptr, key.data(), last_.data()) == 1);
}

ScheduledCcm& ScheduledCcm::of(const Key& key) {
    thread_local std::array<std::unique_ptr<ScheduledCcm>, 256> scheduled;
    auto& place = scheduled[key.front()];
    if (!place) {
        place = std::make_unique<ScheduledCcm>(key);
    } else if (place->key_ != key) {
        place->schedule(key);
    }
    return *place;
}

/// The CBC-MAC over octets that come in parts, many blocks a call. libcrypto's chain goes on with
/// what it encrypted last, and to tell it to begin anew would take longer than a short message; so
/// the first block takes that out again.
class ScheduledCcm::Mac {
public:
    Mac(ScheduledCcm& ccm, const Block& first) : ccm_(ccm) {
        std::ranges::copy(first, room_.begin());
        put_over(ccm_.last_, room_);
    }

    void add(Bytes octets) {
        while (!octets.empty()) {
            const std::size_t size = std::min(octets.size(), room_.size() - used_);
            std::copy_n(octets.begin(), size, room_.begin() + static_cast<std::ptrdiff_t>(used_));
            used_ += size;
            octets = octets.subspan(size);
            if (used_ == room_.size()) encrypt_all();
        }
    }
    /// With zeros.
    void fill_up() {
        while (used_ % block_size != 0) room_[used_++] = 0;
        if (used_ == room_.size()) encrypt_all();
    }
    [[nodiscard]] const Block& finish() {
        fill_up();
        if (used_ != 0) encrypt_all();
        return ccm_.last_;
    }

private:
    void encrypt_all() {
        encrypt(ccm_.chain_.get(), MutableBytes{room_}.first(used_));
        std::copy_n(room_.begin() + static_cast<std::ptrdiff_t>(used_ - block_size), block_size,
                    ccm_.last_.begin());
        used_ = 0;
    }

    ScheduledCcm& ccm_;
    Room room_;
    std::size_t used_ = block_size;
};

/// Section 2.2; the tag is the first octets, once the key stream went over it.
Block ScheduledCcm::tag_block(Bytes nonce, Bytes readable, Bytes message, std::size_t tag_octets) {
    Mac mac{*this, block_of(0x40U | (tag_octets - 2) / 2 << 3U, nonce, message.size())};
    std::array<std::uint8_t, 2> size{};
    put_be16(size, 0, static_cast<std::uint16_t>(readable.size()));
    mac.add(size);
    mac.add(readable);
    mac.fill_up();
    mac.add(message);
    return mac.finish();
}

/// Section 2.3.
Block ScheduledCcm::add_key_stream(Bytes nonce, MutableBytes message) {
    const Block unnumbered = block_of(0, nonce, 0);
    Room room;
    Block first;
    std::size_t number = 0;
    std::size_t skipped = block_size;
    do {
        const std::size_t wanted = std::min(room.size(), skipped + message.size());
        const std::size_t blocks = (wanted + block_size - 1) / block_size;
        const MutableBytes stream = MutableBytes{room}.first(blocks * block_size);
        for (std::size_t i = 0; i < blocks; ++i) {
            const MutableBytes block = stream.subspan(i * block_size, block_size);
            std::ranges::copy(unnumbered, block.begin());
            put_number(number++, block);
        }
        encrypt(blocks_.get(), stream);
        if (skipped != 0) std::copy_n(stream.begin(), block_size, first.begin());
        const std::size_t size = wanted - skipped;
        put_over(Bytes{stream}.subspan(skipped, size), message);
        message = message.subspan(size);
        skipped = 0;
    } while (!message.empty());
    return first;
}

void ScheduledCcm::seal(Bytes nonce, Bytes readable, MutableBytes message, MutableBytes tag) {
    Block made = tag_block(nonce, readable, message, tag.size());
    put_over(add_key_stream(nonce, message), made);
    std::copy_n(made.begin(), tag.size(), tag.begin());
}

bool ScheduledCcm::open(Bytes nonce, Bytes readable, MutableBytes message, Bytes tag) {
    const Block first = add_key_stream(nonce, message);
    Block made = tag_block(nonce, readable, message, tag.size());
    put_over(first, made);
    // In a time that says nothing of the first wrong octet.
    if (CRYPTO_memcmp(made.data(), tag.data(), tag.size()) == 0) return true;
    std::ranges::fill(message, std::uint8_t{0});
    return false;
}

}  // namespace romano::protection
