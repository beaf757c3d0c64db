// By what brokers know each other (DDS Security 1.1): the files in a broker's --keys folder, which
// DDS reads when the broker starts.
//
//     authority.pem       whose signatures count
//     broker.pem          this broker's certificate and private key
//     governance.p7s      what is protected: all packets, discovery included; nobody joins unproven
//     permissions.p7s     that this broker may write and read the topics of a cluster
//     revoked.pem         certificates that count no more
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "romano/keys/authority.h"

namespace romano::keys {

inline constexpr const char* governance_name = "governance.p7s";
inline constexpr const char* permissions_name = "permissions.p7s";
inline constexpr const char* revoked_name = "revoked.pem";

/// Valid as long as a certificate that is made now for so many days.
void write_peer_papers(const Authority& authority, std::string_view broker,
                       const std::filesystem::path& folder, int days);

[[nodiscard]] bool has_peer_papers(const std::filesystem::path& folder);

/// Why DDS would refuse them, a sentence each; empty when it would not.
[[nodiscard]] std::vector<std::string> problems_of_peer_papers(const std::filesystem::path& folder);

}  // namespace romano::keys
