// The keys of an association on their way between brokers, under the key that the client and all
// brokers share: whoever hears the brokers learns nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "broker/dtls/association.h"
#include "romano/base/bytes.h"
#include "romano/dtls/record/record_cipher.h"
#include "romano/protection/keys.h"

namespace romano::dtls {

inline constexpr std::size_t wrapped_octets = 1 + 2 * (16 + 4) + 8;
using WrappedKeys = std::array<std::uint8_t, wrapped_octets>;

[[nodiscard]] WrappedKeys wrap(const RecordKeys& keys, const protection::RobotKey& client,
                               std::string_view client_id, AssociationId id);

/// Nothing when they are not of that client, association and key.
[[nodiscard]] std::optional<RecordKeys> unwrap(Bytes wrapped, const protection::RobotKey& client,
                                               std::string_view client_id, AssociationId id);

}  // namespace romano::dtls
