#include "broker/daemon/processor_load.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>

namespace romano::daemon {

void ProcessorLoad::on_reading(Instant now, Duration used) {
    if (!readings_.empty() && now - readings_.back().at < least_apart) return;
    readings_.push_back({now, used});
    while (readings_.size() > 2 && now - readings_[1].at >= window) readings_.pop_front();
}

std::uint32_t ProcessorLoad::percent() const {
    if (readings_.size() < 2) return 0;
    const std::chrono::duration<double> used = readings_.back().used - readings_.front().used;
    const std::chrono::duration<double> passed = readings_.back().at - readings_.front().at;
    return static_cast<std::uint32_t>(std::lround(std::max(0.0, 100 * (used / passed))));
}

Duration process_processor_time() {
    timespec time{};
    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return std::chrono::duration_cast<Duration>(std::chrono::seconds{time.tv_sec} +
                                                std::chrono::nanoseconds{time.tv_nsec});
}

}  // namespace romano::daemon
