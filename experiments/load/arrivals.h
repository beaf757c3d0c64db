// What has arrived of each stream at each of its subscribers: one bit a message, so that loss,
// copies and order are exact however late something comes. Where a stream has several subscribers,
// also how many of them have each message.
#pragma once

#include <cstdint>
#include <vector>

namespace romano::experiments {

class Arrivals {
public:
    /// `receivers`: the most subscribers that a stream has.
    Arrivals(std::uint32_t streams, std::uint32_t receivers)
        : receivers_(receivers), of_pair_(std::size_t{streams} * receivers), having_(streams) {}

    /// False for a copy.
    bool note(std::uint32_t stream, std::uint32_t receiver, std::uint32_t sequence) {
        Pair& pair = of_pair_[std::size_t{stream} * receivers_ + receiver];
        const std::size_t word = sequence / 64;
        if (word >= pair.bits.size()) pair.bits.resize(word + word / 2 + 1);
        const std::uint64_t bit = std::uint64_t{1} << (sequence % 64);
        if ((pair.bits[word] & bit) != 0) {
            ++duplicates_;
            return false;
        }
        pair.bits[word] |= bit;
        ++delivered_;
        if (receivers_ > 1) count(having_[stream], sequence);
        if (sequence < pair.next) {
            ++out_of_order_;
        } else {
            pair.next = sequence + 1;
        }
        return true;
    }

    /// How many subscribers have that message, of which one has come just now.
    [[nodiscard]] std::uint32_t receivers_having(std::uint32_t stream,
                                                 std::uint32_t sequence) const {
        return receivers_ > 1 ? having_[stream][sequence] : 1;
    }

    [[nodiscard]] std::uint64_t delivered() const { return delivered_; }
    [[nodiscard]] std::uint64_t duplicates() const { return duplicates_; }
    /// First copies that came behind a later message of their stream.
    [[nodiscard]] std::uint64_t out_of_order() const { return out_of_order_; }

private:
    struct Pair {
        std::uint32_t next = 0;  // behind the highest that came
        std::vector<std::uint64_t> bits;
    };

    static void count(std::vector<std::uint32_t>& having, std::uint32_t sequence) {
        if (sequence >= having.size()) having.resize(sequence + sequence / 2 + 1);
        ++having[sequence];
    }

    std::uint32_t receivers_;
    std::vector<Pair> of_pair_;
    std::vector<std::vector<std::uint32_t>> having_;  // by stream and sequence
    std::uint64_t delivered_ = 0;
    std::uint64_t duplicates_ = 0;
    std::uint64_t out_of_order_ = 0;
};

}  // namespace romano::experiments
