#include "experiments/robots/stamp.h"

#include <cassert>

namespace romano::experiments {
namespace {

void put(MutableBytes octets, std::size_t at, std::size_t width, std::uint64_t value) {
    for (std::size_t i = width; i-- > 0; value >>= 8U) {
        octets[at + i] = static_cast<std::uint8_t>(value & 0xFFU);
    }
}

std::uint64_t get(Bytes octets, std::size_t at, std::size_t width) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < width; ++i) value = (value << 8U) | octets[at + i];
    return value;
}

}  // namespace

void write_stamp(const Stamp& stamp, MutableBytes payload) {
    assert(payload.size() >= Stamp::octets);
    put(payload, 0, 4, stamp.publisher);
    put(payload, 4, 4, stamp.sequence);
    put(payload, 8, 8, static_cast<std::uint64_t>(stamp.sent_at.time_since_epoch().count()));
}

std::optional<Stamp> read_stamp(Bytes payload) {
    if (payload.size() < Stamp::octets) return std::nullopt;
    return Stamp{static_cast<RobotNumber>(get(payload, 0, 4)),
                 static_cast<std::uint32_t>(get(payload, 4, 4)),
                 Instant{Duration{static_cast<std::int64_t>(get(payload, 8, 8))}}};
}

}  // namespace romano::experiments
