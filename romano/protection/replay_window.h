// Which numbers of a sender were there: the newest, and which of those just below (as in RFC 4303
// section 3.4.3). What is older counts as having been there.
//
// Numbers are asked about before a packet is verified, and noted after.
#pragma once

#include <cstdint>

namespace romano::protection {

class ReplayWindow {
public:
    static constexpr std::uint32_t width = 32;

    ReplayWindow() = default;
    /// All numbers below `floor` count as having been there.
    explicit ReplayWindow(std::uint32_t floor) : end_(floor), seen_(~std::uint32_t{0}) {}

    [[nodiscard]] bool has_seen(std::uint32_t number) const {
        if (number >= end_) return false;
        const std::uint32_t age = end_ - 1 - number;
        return age >= width || (seen_ >> age & 1U) != 0;
    }
    [[nodiscard]] bool is_newest(std::uint32_t number) const { return number >= end_; }

    /// `number` is below max_number (reserve.h) and was not seen.
    void note(std::uint32_t number) {
        if (number < end_) {
            seen_ |= std::uint32_t{1} << (end_ - 1 - number);
            return;
        }
        const std::uint32_t steps = number + 1 - end_;
        seen_ = steps >= width ? 1U : seen_ << steps | 1U;
        end_ = number + 1;
    }

    /// All numbers that were seen are below.
    [[nodiscard]] std::uint32_t end() const { return end_; }

private:
    std::uint32_t end_ = 0;
    std::uint32_t seen_ = 0;  // bit n: end_ - 1 - n
};

}  // namespace romano::protection
