// A Connection ID (RFC 9146): octets that its receiver chose, in front of which a record finds its
// association from whatever address it comes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "romano/base/bytes.h"

namespace romano::dtls {

class ConnectionId {
public:
    /// RFC 9146 section 3 allows 255; who wants more than this is served without one.
    static constexpr std::size_t most_octets = 32;

    /// Empty: its receiver needs none.
    ConnectionId() = default;
    /// Nothing when they are too many.
    [[nodiscard]] static std::optional<ConnectionId> of(Bytes octets) {
        if (octets.size() > most_octets) return std::nullopt;
        ConnectionId out;
        std::copy(octets.begin(), octets.end(), out.octets_.begin());
        out.size_ = static_cast<std::uint8_t>(octets.size());
        return out;
    }

    [[nodiscard]] Bytes octets() const { return Bytes{octets_}.first(size_); }
    [[nodiscard]] bool empty() const { return size_ == 0; }

    friend bool operator==(const ConnectionId&, const ConnectionId&) = default;

private:
    std::array<std::uint8_t, most_octets> octets_{};
    std::uint8_t size_ = 0;
};

}  // namespace romano::dtls
