#include "romano/protection/ccm.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace romano::protection {
namespace {

/// The CBC-MAC over octets that come in parts. A block is encrypted when the next one begins.
class Mac {
public:
    Mac(const Key& key, const Block& first) : key_(key), state_(first) {}
    void add(Bytes octets) {
        for (const std::uint8_t octet : octets) {
            if (used_ == state_.size()) {
                encrypt(key_, state_);
                used_ = 0;
            }
            state_[used_++] ^= octet;
        }
    }
    /// With zeros.
    void fill_up() { used_ = state_.size(); }
    [[nodiscard]] Block finish() {
        encrypt(key_, state_);
        return state_;
    }

private:
    const Key& key_;
    Block state_;
    std::size_t used_ = 16;
};

}  // namespace

Ccm::Ccm(const Key& key, Bytes nonce) : key_(key), numbered_{} {
    numbered_[0] = static_cast<std::uint8_t>(14 - nonce.size());
    for (std::size_t i = 0; i < nonce.size(); ++i) numbered_[1 + i] = nonce[i];
}

void Ccm::seal(Bytes readable, MutableBytes message, MutableBytes tag) const {
    const Block made = tag_block(readable, message, tag.size());
    for (std::size_t i = 0; i < tag.size(); ++i) tag[i] = made[i];
    add_key_stream(1, message);
}

bool Ccm::open(Bytes readable, MutableBytes message, Bytes tag) const {
    add_key_stream(1, message);
    const Block made = tag_block(readable, message, tag.size());
    // All octets are compared: the time says nothing of the first wrong one.
    unsigned difference = 0;
    for (std::size_t i = 0; i < tag.size(); ++i) difference |= unsigned{tag[i]} ^ made[i];
    if (difference == 0) return true;
    std::fill(message.begin(), message.end(), std::uint8_t{0});
    return false;
}

/// B_0 and the A_i: flags, nonce and, in the rest, a number.
Block Ccm::block(std::uint8_t flags, std::size_t number) const {
    Block made = numbered_;
    made[0] |= flags;
    for (std::size_t at = 15; number != 0; --at, number >>= 8U) {
        made[at] = static_cast<std::uint8_t>(number);
    }
    return made;
}

/// Section 2.2; the tag is the first octets.
Block Ccm::tag_block(Bytes readable, Bytes message, std::size_t tag_octets) const {
    assert(!readable.empty() && readable.size() < 0xFF00);
    const auto flags = static_cast<std::uint8_t>(0x40U | (tag_octets - 2) / 2 << 3U);
    Mac mac{key_, block(flags, message.size())};
    std::uint8_t size[2];
    put_be16(size, 0, static_cast<std::uint16_t>(readable.size()));
    mac.add(size);
    mac.add(readable);
    mac.fill_up();
    mac.add(message);
    Block made = mac.finish();
    add_key_stream(0, made);
    return made;
}

/// Section 2.3: S_0 goes over the tag, those behind it over the message, both ways.
void Ccm::add_key_stream(std::size_t from, MutableBytes octets) const {
    for (; !octets.empty(); ++from) {
        Block stream = block(0, from);
        encrypt(key_, stream);
        const std::size_t size = std::min(octets.size(), stream.size());
        for (std::size_t i = 0; i < size; ++i) octets[i] ^= stream[i];
        octets = octets.subspan(size);
    }
}

}  // namespace romano::protection
