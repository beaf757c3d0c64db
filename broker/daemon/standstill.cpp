#include "broker/daemon/standstill.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>

namespace romano::daemon {
namespace {

auto in_ms(Duration duration) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(duration).count();
}

}  // namespace

void Standstill::look(Instant now, Instant due, Duration worked) {
    const Instant before = std::exchange(seen_at_, now);
    const Duration work = worked - std::exchange(worked_before_, worked);
    if (before == Instant::min()) return;
    const Duration late = now - std::max(due, before);
    if (late < detection_timeout_ / 2) return;
    if (now < quiet_until_) return;
    quiet_until_ = now + said_again_after;
    spdlog::warn(
        "stood still for {} ms, {} ms of them at work; peers replace a broker after {} ms (more "
        "time: --detection-timeout-ms; before other programs: --realtime)",
        in_ms(late), in_ms(std::min(work, late)), in_ms(detection_timeout_));
}

Duration thread_processor_time() {
    timespec time{};
    (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::chrono::duration_cast<Duration>(std::chrono::seconds{time.tv_sec} +
                                                std::chrono::nanoseconds{time.tv_nsec});
}

}  // namespace romano::daemon
