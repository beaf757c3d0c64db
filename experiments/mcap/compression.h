// The records of a chunk, made smaller and as they were; and their checksum.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "experiments/mcap/records.h"

namespace romano::experiments::mcap {

inline constexpr std::string_view zstd = "zstd";

/// CRC-32 as in zlib, of octets that follow those of which it was `before`.
[[nodiscard]] std::uint32_t crc32_of(Bytes octets, std::uint32_t before = 0);

[[nodiscard]] Octets compressed_with_zstd(Bytes records);

/// Exactly `size` octets; empty when these are not what is in there, or the compression is neither
/// "zstd" nor none.
[[nodiscard]] std::optional<Octets> uncompressed(std::string_view compression, Bytes records,
                                                 std::size_t size);

}  // namespace romano::experiments::mcap
