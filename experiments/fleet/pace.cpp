#include "experiments/fleet/pace.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace romano::experiments {
namespace {

constexpr std::chrono::seconds a_second{1};

}  // namespace

bool Pace::on_tick(Instant now, std::uint64_t version) {
    if (!ends_) ends_ = now + a_second;
    if (now < *ends_) return false;
    // A watcher that was stopped for a while has one long second, and no flood of empty ones.
    end_second(now, version);
    ends_ = now - *ends_ < a_second ? *ends_ + a_second : now + a_second;
    return true;
}

void Pace::end_second(Instant end, std::uint64_t version) {
    now_.changed = version;
    now_.end = end;
    if (!delays_.empty()) {
        const auto middle = delays_.begin() + static_cast<std::ptrdiff_t>(delays_.size() / 2);
        std::ranges::nth_element(delays_, middle);
        now_.delay = *middle;
        now_.worst_delay = *std::ranges::max_element(delays_);
    }
    delays_.clear();
    seconds_.push_back(std::exchange(now_, {}));
    if (seconds_.size() > most_seconds) seconds_.pop_front();
}

}  // namespace romano::experiments
