// Only one testbed has a machine at a time: the session of a sweep, or what `romano testbed start`
// keeps running. The kernel keeps the books: a claim ends with its process.
#pragma once

#include <optional>
#include <string>

#include "experiments/sweep/claim.h"

namespace romano::experiments {

enum class Holder { sweep, keeper };

class MachineClaim {
public:
    /// Empty when somebody else has the machine.
    [[nodiscard]] static std::optional<MachineClaim> take(Holder holder);

private:
    MachineClaim(Claim machine, Claim holder)
        : machine_(std::move(machine)), holder_(std::move(holder)) {}

    Claim machine_;
    Claim holder_;  // its name says who it is
};

/// "a sweep", "romano testbed start"; empty when nobody has it.
[[nodiscard]] std::string who_has_the_machine();

}  // namespace romano::experiments
