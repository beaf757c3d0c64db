// Of a build without ns-3.
#include <stdexcept>

#include "experiments/loops/radio_brokers.h"

namespace romano::experiments {

const bool has_radio = false;

std::unique_ptr<FaultyBrokers> make_radio_brokers(std::uint64_t, std::size_t) {
    throw std::runtime_error("this build has no radio channel");
}

}  // namespace romano::experiments
