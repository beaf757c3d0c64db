// One run of the pendulum over a lone broker: does the pole stay up?
//
// The cart's robot and the law's talk through a broker core on a network with a fixed delay each
// way and random losses. The pole is let go at a small angle, there is no wind, and it stays up if
// at the end of the run it stands straighter than it began.
#pragma once

#include <cstdint>

#include "experiments/loops/cart_pole.h"
#include "romano/base/time.h"

namespace romano::experiments {

struct BalanceCase {
    std::uint16_t period_ms = 20;
    Duration delay{0};  // of a round: from the sample to its command
    double loss = 0;    // of rounds
    std::uint64_t seed = 1;
    Duration lasts{std::chrono::seconds{20}};
};

struct BalanceRun {
    bool stays_up = false;
    double stood_s = 0;  // until it had fallen, or all the time
    // As the plant itself counted:
    std::uint32_t samples = 0;   // but for the latest ones, whose commands are on their way
    std::uint32_t commands = 0;  // that it carried out
    double greatest_delay_s = 0;
};

[[nodiscard]] BalanceRun balance(const CartPoleBody& body, const BalanceCase& setting);

}  // namespace romano::experiments
