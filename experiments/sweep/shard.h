// A part of a sweep's cells, for one of several machines: every N-th cell.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace romano::experiments {

inline constexpr std::uint32_t most_shards = 100'000;

struct Shard {
    std::uint32_t number = 1;  // from 1 to `of`
    std::uint32_t of = 1;
};

/// "2/8". Empty when the text is none.
[[nodiscard]] std::optional<Shard> parse_shard(std::string_view text);
[[nodiscard]] std::string text_of(const Shard& shard);

}  // namespace romano::experiments
