// In whose name a message speaks, and how the core sees and refuses clients with keys: the same for
// all ways to prove who one is.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "broker/core/actions.h"
#include "broker/core/client_address.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/mqttsn/frame.h"

namespace romano::broker {

/// Whose the message says that it is: CONNECT, and a sleeping client's PINGREQ (6.14).
[[nodiscard]] std::optional<std::string_view> named_client(const mqttsn::Frame& frame);

/// A message in no other client's name than this. What is no message is: the core counts it.
[[nodiscard]] bool is_own_name(std::string_view client_id, Bytes message);

/// What put_node_id() needs in front of a message.
[[nodiscard]] constexpr std::size_t node_id_octets(std::string_view node_id) {
    return 3 + node_id.size();
}
/// The header of a forwarder (5.5), for a message that lies behind it.
void put_node_id(std::string_view node_id, MutableBytes out);

/// CONNACK 3, "not supported".
void refuse_connect(const Endpoint& via, const ClientAddress& to, Actions& out);

}  // namespace romano::broker
