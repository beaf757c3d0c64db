// FNV-1a (Fowler, Noll and Vo; draft-eastlake-fnv): a number of some octets that is the same in
// every build and on every machine. It is no protection against somebody who wants two alike.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace romano {

template <typename Number>
requires std::same_as<Number, std::uint32_t> || std::same_as<Number, std::uint64_t>
class Fnv1a {
public:
    constexpr void add(std::uint8_t octet) {
        hash_ ^= octet;
        hash_ *= prime;
    }
    /// Octet by octet: two texts in a row are one.
    constexpr void add(std::string_view text) {
        for (const char c : text) add(static_cast<std::uint8_t>(c));
    }
    /// Lowest octet first.
    template <std::unsigned_integral Value>
    requires(sizeof(Value) > 1) constexpr void add(Value value) {
        for (std::size_t octet = 0; octet < sizeof(Value); ++octet) {
            add(static_cast<std::uint8_t>(value >> 8U * octet));
        }
    }
    [[nodiscard]] constexpr Number value() const { return hash_; }

private:
    static constexpr bool wide = sizeof(Number) == 8;
    static constexpr Number prime = static_cast<Number>(wide ? 0x100000001b3ULL : 0x01000193ULL);
    Number hash_ = static_cast<Number>(wide ? 0xcbf29ce484222325ULL : 0x811c9dc5ULL);
};

/// Of one text.
template <typename Number>
constexpr Number fnv1a(std::string_view text) {
    Fnv1a<Number> hash;
    hash.add(text);
    return hash.value();
}

}  // namespace romano
