// Where things are, as Protobuf: endpoints, logs, positions; and how numbers are narrowed safely.
//
// All conversions of this folder: to_proto() writes a value, from_proto() gives a whole value or
// nothing when a field holds what its type cannot. They live in the namespace of the generated
// types, so that each finds the others by its argument.
#pragma once

#include <concepts>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "broker/core/log_position.h"
#include "overlay/dds/session.pb.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::overlay::proto {

void to_proto(const romano::Endpoint& in, Endpoint& out);
[[nodiscard]] std::optional<romano::Endpoint> from_proto(const Endpoint& in);

void to_proto(const broker::LogId& in, LogId& out);
[[nodiscard]] std::optional<broker::LogId> from_proto(const LogId& in);

void to_proto(const broker::LogPosition& in, LogPosition& out);
[[nodiscard]] std::optional<broker::LogPosition> from_proto(const LogPosition& in);

/// An enumerator with a value from 0 to `last`.
template <typename Enum>
[[nodiscard]] std::optional<Enum> enum_from(std::uint32_t value, Enum last) {
    if (value > static_cast<std::uint32_t>(last)) return std::nullopt;
    return static_cast<Enum>(value);
}

/// A number, or a strong type over one, that is narrower than Protobuf's 32 bits.
template <typename Number>
[[nodiscard]] std::optional<Number> narrow(std::uint32_t value) {
    if constexpr (std::is_enum_v<Number>) {
        const auto number = narrow<std::underlying_type_t<Number>>(value);
        return number ? std::optional(static_cast<Number>(*number)) : std::nullopt;
    } else {
        if (value > std::numeric_limits<Number>::max()) return std::nullopt;
        return static_cast<Number>(value);
    }
}

inline std::vector<std::uint8_t> octets_of(const std::string& bytes) {
    const Bytes view = as_octets(bytes);
    return {view.begin(), view.end()};
}

template <typename In, typename Repeated>
void all_to_proto(const In& in, Repeated& out) {
    out.Reserve(static_cast<int>(in.size()));
    for (const auto& item : in) to_proto(item, *out.Add());
}

/// True, and all are in `out`, when each of them converts.
template <typename Repeated, typename Out>
[[nodiscard]] bool all_from_proto(const Repeated& in, std::vector<Out>& out) {
    out.reserve(static_cast<std::size_t>(in.size()));
    for (const auto& item : in) {
        auto value = from_proto(item);
        if (!value) return false;
        out.push_back(std::move(*value));
    }
    return true;
}

}  // namespace romano::overlay::proto
