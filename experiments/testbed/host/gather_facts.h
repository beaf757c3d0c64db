// Looks at the machine on which it runs.
#pragma once

#include <filesystem>

#include "experiments/testbed/host_facts.h"

namespace romano::experiments {

/// Takes about a second: so long a neighbour has to answer for an address. `programs` is the folder
/// with romano-broker.
[[nodiscard]] HostFacts gather_facts(const FactsRequest& request,
                                     const std::filesystem::path& programs);

}  // namespace romano::experiments
