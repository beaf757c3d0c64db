// The numbers that a sender may give its packets: each once in the sender's life, through crashes.
//
// Before a number is used the shell has stored a bound above it, in flash or in a file. After a
// restart numbering begins at the stored bound: what was used before lies below. To be asked ahead,
// and seldom, the bound is up to two blocks away; further, where somebody numbers fast.
//
//   Reserve reserve{stored};                                    // 0 for a sender that never was
//   if (const auto bound = reserve.to_store()) { write(*bound); reserve.on_stored(*bound); }
//
// What the shell owes: a bound that on_stored() was told of is found after a crash, or one above.
// Whoever cannot read the stored bound does not begin at 0 but ends: a robot needs a new key then,
// a broker a new identity.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace romano::protection {

inline constexpr std::uint32_t numbers_a_block = 4096;

/// Numbers are below. What is left above keeps sums with numbers and bounds from wrapping.
inline constexpr std::uint32_t max_number = 0U - 4 * numbers_a_block;

class Reserve {
public:
    explicit Reserve(std::uint32_t stored) : unused_(stored), stored_(stored) {}

    /// What is to be stored now; nothing while there is enough. `step`, a power of two of blocks:
    /// the bound is up to two steps away, and a crash wastes as many numbers.
    [[nodiscard]] std::optional<std::uint32_t> to_store(
        std::uint32_t step = numbers_a_block) const {
        constexpr std::uint32_t last = max_number + 2 * numbers_a_block;
        const std::uint32_t begun = unused_ & ~(step - 1);
        const std::uint32_t wanted = begun + std::min(2 * step, last - begun);
        if (wanted <= stored_) return std::nullopt;
        return wanted;
    }
    void on_stored(std::uint32_t bound) { stored_ = bound; }

    [[nodiscard]] bool has(std::uint32_t number) const { return number < stored_; }
    void on_used(std::uint32_t number) { unused_ = std::max(unused_, number + 1); }

    /// Nobody has used it or one above.
    [[nodiscard]] std::uint32_t unused() const { return unused_; }

    /// The first number of the block.
    static constexpr std::uint32_t block_of(std::uint32_t number) {
        return number & ~(numbers_a_block - 1);
    }

private:
    std::uint32_t unused_;
    std::uint32_t stored_;
};

}  // namespace romano::protection
