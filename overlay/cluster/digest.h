// FNV-1a: the same number at every broker, in every build. Whoever has another one asks for the
// whole.
#pragma once

#include <cstdint>
#include <string_view>

namespace romano::cluster {

class Digest {
public:
    void add(std::uint8_t octet) { hash_ = (hash_ ^ octet) * 0x01000193; }
    /// Octet by octet: two texts in a row are one.
    void add(std::string_view text) {
        for (const char c : text) add(static_cast<std::uint8_t>(c));
    }
    void add(std::uint64_t number) {
        for (int octet = 0; octet < 8; ++octet, number >>= 8U) {
            add(static_cast<std::uint8_t>(number & 0xFFU));
        }
    }
    [[nodiscard]] std::uint32_t value() const { return hash_; }

private:
    std::uint32_t hash_ = 0x811C9DC5;
};

}  // namespace romano::cluster
