#include "experiments/sweep/shard.h"

#include <charconv>

namespace romano::experiments {
namespace {

bool read_number(std::string_view text, std::uint32_t& number) {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    return error == std::errc{} && stop == end;
}

}  // namespace

std::optional<Shard> parse_shard(std::string_view text) {
    const auto slash = text.find('/');
    if (slash == std::string_view::npos) return std::nullopt;
    Shard shard;
    if (!read_number(text.substr(0, slash), shard.number)) return std::nullopt;
    if (!read_number(text.substr(slash + 1), shard.of)) return std::nullopt;
    const bool exists = shard.number >= 1 && shard.number <= shard.of && shard.of <= most_shards;
    return exists ? std::optional{shard} : std::nullopt;
}

std::string text_of(const Shard& shard) {
    return std::to_string(shard.number) + "/" + std::to_string(shard.of);
}

}  // namespace romano::experiments
