// Where an event stands: which broker's log, and how far into it.
//
// Every broker writes one log about its own sessions and publishes (one writer). A restarted broker
// begins a new log under a higher incarnation.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "romano/base/fnv1a.h"

namespace romano::broker {

/// Stable number of a broker's name (see broker_id_of). Order breaks ties in elections.
enum class BrokerId : std::uint64_t {};

/// Two names with one id are refused when brokers meet.
constexpr BrokerId broker_id_of(std::string_view name) {
    return BrokerId{fnv1a<std::uint64_t>(name)};
}

/// Number of an event in its log; the first is 1. 0 means "before the first event".
using Seq = std::uint64_t;

struct LogId {
    BrokerId broker{};
    std::uint64_t incarnation = 0;

    friend bool operator==(const LogId&, const LogId&) = default;
    friend auto operator<=>(const LogId&, const LogId&) = default;
};

struct LogPosition {
    LogId log;
    Seq seq = 0;

    friend bool operator==(const LogPosition&, const LogPosition&) = default;
    friend auto operator<=>(const LogPosition&, const LogPosition&) = default;
};

/// How far into that log; none when no position names it.
inline std::optional<Seq> seq_of(std::span<const LogPosition> positions, const LogId& log) {
    for (const LogPosition& position : positions) {
        if (position.log == log) return position.seq;
    }
    return std::nullopt;
}

struct LogPositionHash {
    std::size_t operator()(const LogPosition& p) const {
        std::uint64_t h = static_cast<std::uint64_t>(p.log.broker) * 0x9E3779B97F4A7C15ULL;
        h = (h ^ p.log.incarnation) * 0x9E3779B97F4A7C15ULL;
        h = (h ^ p.seq) * 0x9E3779B97F4A7C15ULL;
        return static_cast<std::size_t>(h ^ (h >> 32U));
    }
};

}  // namespace romano::broker
