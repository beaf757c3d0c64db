#include "overlay/link/hello.h"

#include <algorithm>

namespace romano::link {
namespace {

constexpr std::array<std::uint8_t, 5> opening = {'R', 'L', 'N', 'K', 1};

void put(MutableBytes octets, std::uint64_t value) {
    for (std::size_t i = 8; i-- > 0; value >>= 8U) {
        octets[i] = static_cast<std::uint8_t>(value & 0xFFU);
    }
}

std::uint64_t get(Bytes octets) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 8; ++i) value = (value << 8U) | octets[i];
    return value;
}

void put(MutableBytes octets, const broker::LogId& id) {
    put(octets.first(8), static_cast<std::uint64_t>(id.broker));
    put(octets.subspan(8, 8), id.incarnation);
}

broker::LogId get_id(Bytes octets) {
    return {broker::BrokerId{get(octets.first(8))}, get(octets.subspan(8, 8))};
}

}  // namespace

std::array<std::uint8_t, Hello::octets> encode(const Hello& hello) {
    std::array<std::uint8_t, Hello::octets> out{};
    std::ranges::copy(opening, out.begin());
    put(MutableBytes{out}.subspan(5, 16), hello.from);
    put(MutableBytes{out}.subspan(21, 16), hello.to);
    return out;
}

std::optional<Hello> decode(Bytes octets) {
    if (octets.size() != Hello::octets) return std::nullopt;
    if (!std::ranges::equal(octets.first(opening.size()), opening)) return std::nullopt;
    return Hello{get_id(octets.subspan(5, 16)), get_id(octets.subspan(21, 16))};
}

}  // namespace romano::link
