// How old the commands of a loop are, in numbers that need no memory of each: the last, the least
// and the greatest age, a smoothed one, and the jitter as RFC 3550 section 6.4.1 has it.
#pragma once

#include <algorithm>
#include <cstdint>

#include "romano/control/messages.h"

namespace romano::control {

class DelayMeter {
public:
    void add(std::uint32_t age_us) {
        if (!has_any_) {
            has_any_ = true;
            ages_ = {age_us, age_us, age_us, age_us, 0};
            smoothed_16_ = std::uint64_t{age_us} * 16U;
            return;
        }
        const std::uint32_t change =
            age_us > ages_.last ? age_us - ages_.last : ages_.last - age_us;
        smoothed_16_ += age_us - smoothed_16_ / 16U;
        jitter_16_ += change - jitter_16_ / 16U;
        ages_.last = age_us;
        ages_.least = std::min(ages_.least, age_us);
        ages_.greatest = std::max(ages_.greatest, age_us);
        ages_.smoothed = static_cast<std::uint32_t>(smoothed_16_ / 16U);
        ages_.jitter = static_cast<std::uint32_t>(jitter_16_ / 16U);
    }

    [[nodiscard]] bool has_any() const { return has_any_; }
    [[nodiscard]] const Ages& ages() const { return ages_; }

private:
    bool has_any_ = false;
    Ages ages_;
    std::uint64_t smoothed_16_ = 0;  // sixteen times the value, so that nothing is rounded away
    std::uint64_t jitter_16_ = 0;
};

}  // namespace romano::control
