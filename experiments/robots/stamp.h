// What an experiment's message carries: who sent it, which of his it is, and when. The first 16
// octets of the payload, big-endian; what follows fills it up to the wanted size.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "experiments/measure/delivery_account.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"

namespace romano::experiments {

struct Stamp {
    static constexpr std::size_t octets = 16;

    RobotNumber publisher = 0;
    std::uint32_t sequence = 0;
    Instant sent_at{};

    friend bool operator==(const Stamp&, const Stamp&) = default;
};

/// `payload` has at least Stamp::octets.
void write_stamp(const Stamp& stamp, MutableBytes payload);
/// Empty when the payload is too short.
[[nodiscard]] std::optional<Stamp> read_stamp(Bytes payload);

}  // namespace romano::experiments
