// A build without ns-3.
#include "experiments/sweep/radio_world.h"

namespace romano::experiments {

void check_radio(const SweepSettings&, const std::vector<Cell>&) {
    throw SweepError(
        "`world = \"radio\"`: this build has no radio channel: install ns-3 (Debian: libns3-dev) "
        "and build again");
}

std::unique_ptr<CellWorld> make_radio_world(const SweepSettings&, const Cell&) {
    return nullptr;  // nobody asks: check_radio() was first
}

}  // namespace romano::experiments
