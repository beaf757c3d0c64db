// A build without ns-3.
#include "experiments/sweep/air_world.h"
#include "experiments/sweep/radio_world.h"

namespace romano::experiments {
namespace {

[[noreturn]] void refuse(const SweepSettings& settings) {
    throw SweepError("`world = \"" + std::string{name_of(settings.world)} +
                     "\"`: this build has no radio channel: install ns-3 (Debian: libns3-dev) and "
                     "build again");
}

}  // namespace

void check_radio(const SweepSettings& settings, const std::vector<Cell>&) {
    refuse(settings);
}

void check_air(const SweepSettings& settings, const std::vector<Cell>&) {
    refuse(settings);
}

std::unique_ptr<CellWorld> make_radio_world(const SweepSettings&, const Cell&) {
    return nullptr;  // nobody asks: check_radio() was first
}

std::unique_ptr<CellWorld> make_air_world(const SweepSettings&, const Cell&, const std::string&,
                                          const std::filesystem::path&) {
    return nullptr;  // nor here
}

}  // namespace romano::experiments
