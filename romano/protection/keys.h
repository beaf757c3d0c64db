// The keys of a robot: from its own key one for each direction, by HKDF with SHA-256 (RFC 5869).
//
// With one key for both directions a broker would open what another broker sent to the robot.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "romano/base/bytes.h"

namespace romano::protection {

using Key = std::array<std::uint8_t, 16>;

/// What a robot and its brokers share.
struct RobotKey {
    Key octets;
};

/// What a person and the brokers share: each of the person's programs is a client of its own, with
/// a key from this one.
struct OperatorKey {
    Key octets;
};

struct DirectionKeys {
    Key to_broker;
    Key to_robot;
};

[[nodiscard]] RobotKey session_key(const OperatorKey& person, std::string_view client_id);
[[nodiscard]] DirectionKeys direction_keys(const RobotKey& robot);
/// For standard clients: the pre-shared key of DTLS (RFC 4279), with the client id as the identity.
[[nodiscard]] Key pre_shared_key(const RobotKey& client);

/// Fills `out`, which has 8,160 octets at most.
void hkdf_sha256(Bytes secret, Bytes salt, std::string_view purpose, Bytes whose, MutableBytes out);

}  // namespace romano::protection
