// A DDS domain that is configured from code, with one participant in it. One per domain id in a
// process; everything else of DDS lives inside it and goes first.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "overlay/dds/entity.h"

namespace romano::dds {

/// Paths of what brokers know each other by (OMG DDS Security 1.1), all of them PEM or S/MIME.
struct Papers {
    std::string authority;
    std::string own;  // certificate and private key
    std::string governance;
    std::string permissions;
    std::string revoked;
};

struct DomainOptions {
    std::uint32_t id = 0;    // 0 to 230
    std::string interface;   // empty: Cyclone DDS chooses
    bool over_ipv6 = false;  // the interface has no IPv4 address: Cyclone uses one of the two only
    /// Without: plain, and whoever reaches the network can join. With: who cannot prove itself
    /// neither joins nor reads. They are read once, when a participant is made.
    std::optional<Papers> papers = {};
};

class Domain {
public:
    /// Throws DdsError.
    explicit Domain(const DomainOptions& options);
    /// With a configuration of one's own, in Cyclone's XML. Throws DdsError.
    Domain(std::uint32_t id, const std::string& configuration);

    /// A participant of its own, for each broker in this process.
    [[nodiscard]] Entity make_participant() const;

private:
    std::uint32_t id_;
    Entity domain_;
};

/// The configuration in Cyclone's XML.
[[nodiscard]] std::string configuration_of(const DomainOptions& options);

}  // namespace romano::dds
