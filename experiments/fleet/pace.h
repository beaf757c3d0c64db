// How busy the fleet is and how fast its broker answers, second by second: messages heard, and the
// delays of echoes, which are messages that the watcher publishes to itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "romano/base/time.h"

namespace romano::experiments {

struct PaceSecond {
    std::uint64_t changed = 0;  // the picture's version when it was over
    Instant end;
    std::uint32_t messages = 0;
    std::uint32_t echoes_lost = 0;
    std::optional<Duration> delay;  // of the echoes that came back in this second: the median
    std::optional<Duration> worst_delay;
};

class Pace {
public:
    static constexpr std::size_t most_seconds = 300;

    void on_message() { ++now_.messages; }
    void on_echo(Duration delay) { delays_.push_back(delay); }
    void on_echo_lost() { ++now_.echoes_lost; }
    /// True when a second is over, and so there is one more.
    bool on_tick(Instant now, std::uint64_t version);

    [[nodiscard]] const std::deque<PaceSecond>& seconds() const { return seconds_; }

private:
    void end_second(Instant end, std::uint64_t version);

    PaceSecond now_;
    std::vector<Duration> delays_;
    std::optional<Instant> ends_;
    std::deque<PaceSecond> seconds_;
};

}  // namespace romano::experiments
