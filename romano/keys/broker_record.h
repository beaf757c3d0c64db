// What a broker must never lose one without the other: the identity under which it numbers its
// packets, drawn at random, its place among the brokers of its fleet, and the bound of the numbers
// that it has used (romano/protection/README.md, "No nonce twice under one key";
// broker/dtls/README.md, "No number twice"). Never to be copied.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "romano/protection/packet.h"

namespace romano::keys {

struct BrokerRecord {
    protection::SenderId identity{};
    std::uint32_t bound = 0;
    std::uint32_t place = 0;  // 0: none, and no DTLS
};

/// A fleet gives out so many places, each once.
inline constexpr std::uint32_t most_places = 127;

/// Drawn anew, and not stored yet, when there is none, or all its numbers are used. Throws KeyError
/// when it cannot be read.
[[nodiscard]] BrokerRecord read_broker_record(const std::filesystem::path& file);
void write_broker_record(const std::filesystem::path& file, const BrokerRecord& record);

/// A place that the fleet's owner gives to a broker: a file of its own until the broker has written
/// it into its record. So a broker that has lost its record, and knows not which numbers it used,
/// has lost its place too. Throws KeyError.
[[nodiscard]] std::optional<std::uint32_t> read_given_place(const std::filesystem::path& file);
void write_given_place(const std::filesystem::path& file, std::uint32_t place);

}  // namespace romano::keys
