// Where the brokers of an experiment live on this machine: a loopback network for a sweep, a DDS
// domain for a cell. Two sweeps at a time, or a sweep beside other brokers, must not meet in one:
// each takes what is free and holds it as long as it lives.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "experiments/sweep/claim.h"

namespace romano::experiments {

struct NetworkPlace {
    std::string network;  // "127.50": brokers listen on <network>.<cell>.<broker>
    Claim claim;
};

/// `wanted`, or the first that is free when it is empty. Empty when there is none.
[[nodiscard]] std::optional<NetworkPlace> claim_network(const std::string& wanted);

struct DomainPlace {
    std::uint32_t domain;
    Claim claim;
};

/// The first free one from `first` on, of the `count` that begin at `base`, in a ring. A domain in
/// which anybody on this machine speaks DDS is not free. Empty when there is none.
[[nodiscard]] std::optional<DomainPlace> claim_domain(std::uint32_t base, std::uint32_t count,
                                                      std::uint32_t first);

}  // namespace romano::experiments
