// What a broker must never lose one without the other: the identity under which it numbers its
// packets, drawn at random, and the bound of the numbers that it has used
// (romano/protection/README.md, "No nonce twice under one key"). Never to be copied.
#pragma once

#include <cstdint>
#include <filesystem>

#include "romano/protection/packet.h"

namespace romano::keys {

struct BrokerRecord {
    protection::SenderId identity{};
    std::uint32_t bound = 0;
};

/// Drawn anew, and not stored yet, when there is none, or all its numbers are used. Throws KeyError
/// when it cannot be read.
[[nodiscard]] BrokerRecord read_broker_record(const std::filesystem::path& file);
void write_broker_record(const std::filesystem::path& file, const BrokerRecord& record);

}  // namespace romano::keys
