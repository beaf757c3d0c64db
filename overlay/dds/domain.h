// A DDS domain that is configured from code, with one participant in it. One per domain id in a
// process; everything else of DDS lives inside it and goes first.
#pragma once

#include <cstdint>
#include <string>

#include "overlay/dds/entity.h"

namespace romano::dds {

struct DomainOptions {
    std::uint32_t id = 0;    // 0 to 230
    std::string interface;   // empty: Cyclone DDS chooses
    bool over_ipv6 = false;  // the interface has no IPv4 address: Cyclone uses one of the two only
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
