// Which sequence numbers a broker may give its records to a client, so that two brokers never use
// one under the same key, and a client never takes an heir's records for old ones.
//
//     47        38 37      31 30                             0
//     generation   place      the broker's own count
//
// The place is the broker's alone in its fleet, for all time (romano/keys/broker_record.h); its
// count goes on through its crashes (romano/protection/reserve.h). The generation rises with each
// broker that begins to speak. README.md, "No number twice".
#pragma once

#include <compare>
#include <cstdint>

namespace romano::dtls {

inline constexpr unsigned count_bits = 31;
inline constexpr unsigned place_bits = 7;
inline constexpr std::uint32_t most_places = (1U << place_bits) - 1;
inline constexpr std::uint32_t most_generation = (1U << (48 - count_bits - place_bits)) - 1;
/// A broker's counts are below.
inline constexpr std::uint32_t most_count = 1U << count_bits;

/// Generation and place, as they stand above the count. 0: nobody has spoken but OpenSSL, whose
/// records of the handshake are numbered from 0.
struct Turn {
    std::uint32_t value = 0;

    [[nodiscard]] constexpr std::uint32_t generation() const { return value >> place_bits; }
    [[nodiscard]] constexpr bool is_last() const { return generation() >= most_generation; }
    [[nodiscard]] constexpr Turn next_of(std::uint32_t place) const {
        return {(generation() + 1) << place_bits | place};
    }
    [[nodiscard]] constexpr std::uint64_t number(std::uint32_t count) const {
        return std::uint64_t{value} << count_bits | count;
    }

    friend constexpr auto operator<=>(const Turn&, const Turn&) = default;
};

}  // namespace romano::dtls
