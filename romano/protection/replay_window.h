// Which numbers of a sender were there: the newest, and which of those just below (as in RFC 4303
// section 3.4.3). What is older counts as having been there.
//
// Numbers are asked about before a packet is verified, and noted after.
#pragma once

#include <cstdint>
#include <limits>

namespace romano::protection {

/// As wide as `Number` has bits.
template <typename Number>
class WindowOf {
public:
    static constexpr Number width = std::numeric_limits<Number>::digits;

    WindowOf() = default;
    /// All numbers below `floor` count as having been there.
    explicit WindowOf(Number floor) : end_(floor), seen_(~Number{0}) {}

    [[nodiscard]] bool has_seen(Number number) const {
        if (number >= end_) return false;
        const Number age = end_ - 1 - number;
        return age >= width || (seen_ >> age & 1U) != 0;
    }
    [[nodiscard]] bool is_newest(Number number) const { return number >= end_; }

    /// `number` was not seen, and is not the highest there is.
    void note(Number number) {
        if (number < end_) {
            seen_ |= Number{1} << (end_ - 1 - number);
            return;
        }
        const Number steps = number + 1 - end_;
        seen_ = steps >= width ? 1U : seen_ << steps | 1U;
        end_ = number + 1;
    }

    /// All numbers that were seen are below.
    [[nodiscard]] Number end() const { return end_; }

private:
    Number end_ = 0;
    Number seen_ = 0;  // bit n: end_ - 1 - n
};

using ReplayWindow = WindowOf<std::uint32_t>;

}  // namespace romano::protection
