// The name of a broker that was given none: of its host and of the address that it serves first.
// All addresses of a machine (0.0.0.0) are no name, as every machine has them, and robots made from
// one image have one host name too: there the hardware address of a network interface tells them
// apart.
#pragma once

#include <string>

#include "romano/base/endpoint.h"

namespace romano::daemon {

inline constexpr std::size_t longest_name = 64;

/// `hardware`: as hardware_address() has it; empty when there is none.
[[nodiscard]] std::string default_name(const std::string& host, const Endpoint& first,
                                       const std::string& hardware);

[[nodiscard]] std::string host_name();
/// Twelve hexadecimal digits, of the first interface whose address its maker gave it, else of the
/// first that has one; empty when none has.
[[nodiscard]] std::string hardware_address();

}  // namespace romano::daemon
