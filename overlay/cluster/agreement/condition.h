// Battery or load in the rank: a reading from 0 to 100 is told so coarsely and so late that the
// lead does not swing between two brokers whose batteries drain together.
#pragma once

#include <algorithm>
#include <cstdint>

namespace romano::cluster {

class Condition {
public:
    static constexpr std::uint32_t best = 100;

    /// We tell the steps 0, 25, 50, 75 and 100. True when the step is another one now.
    bool on_reading(std::uint32_t reading) {
        reading = std::min(reading, best);
        const bool has_left = reading + slack < told_ || reading >= told_ + step + slack ||
                              (reading == best && told_ != best);
        if (!has_left) return false;
        told_ = reading / step * step;
        return true;
    }
    [[nodiscard]] std::uint32_t told() const { return told_; }

private:
    static constexpr std::uint32_t step = 25;
    static constexpr std::uint32_t slack = 5;

    std::uint32_t told_ = best;  // until somebody says otherwise: no battery, and no load
};

}  // namespace romano::cluster
