#include "experiments/testbed/host/machine_claim.h"

namespace romano::experiments {
namespace {

constexpr const char* machine = "testbed";

const char* name_of(Holder holder) {
    return holder == Holder::sweep ? "testbed/sweep" : "testbed/keeper";
}

}  // namespace

std::optional<MachineClaim> MachineClaim::take(Holder holder) {
    auto whole = Claim::on_name(machine);
    if (!whole) return std::nullopt;
    auto name = Claim::on_name(name_of(holder));
    if (!name) return std::nullopt;
    return MachineClaim{std::move(*whole), std::move(*name)};
}

std::string who_has_the_machine() {
    if (Claim::on_name(machine)) return {};
    return Claim::on_name(name_of(Holder::keeper)) ? "a sweep" : "romano testbed start";
}

}  // namespace romano::experiments
