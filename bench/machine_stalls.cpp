#include "bench/machine_stalls.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <future>
#include <stop_token>
#include <utility>

#include "broker/net/clock.h"

namespace romano::bench {
namespace {

constexpr Duration nap = std::chrono::milliseconds{1};

/// True: on that core alone, and before all that runs there.
bool rise_above_all(int core) {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    sched_param parameters{};
    parameters.sched_priority = sched_get_priority_max(SCHED_FIFO);
    return pthread_setaffinity_np(pthread_self(), sizeof one, &one) == 0 &&
           pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}

}  // namespace

void LateWakeUps::on_wake_up(Duration late) {
    if (late < counted_from) return;
    longest_ = std::max(longest_.load(), late);
    ++count_;
}

MachineStalls::MachineStalls() {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
    for (int core = 0; core < CPU_SETSIZE; ++core) {
        if (!CPU_ISSET(core, &allowed)) continue;
        auto& watched = *cores_.emplace_back(std::make_unique<Core>());
        std::promise<bool> may_look;
        auto is_permitted = may_look.get_future();
        watched.thread = std::jthread(
            [core, &late = watched.late](const std::stop_token& stop, std::promise<bool> answer) {
                const bool is_above = rise_above_all(core);
                answer.set_value(is_above);
                while (is_above && !stop.stop_requested()) {
                    const Instant slept_at = net::now();
                    std::this_thread::sleep_for(nap);
                    late.on_wake_up(net::now() - slept_at - nap);
                }
            },
            std::move(may_look));
        if (!is_permitted.get()) {
            cores_.clear();
            return;
        }
    }
}

std::optional<MachineStalls::Seen> MachineStalls::seen() const {
    if (cores_.empty()) return std::nullopt;
    Seen most;
    for (const auto& core : cores_) {
        most.count = std::max(most.count, core->late.count());
        most.longest = std::max(most.longest, core->late.longest());
    }
    return most;
}

std::string text_of(const std::optional<MachineStalls::Seen>& seen) {
    if (!seen) {
        return "Whether the machine stood still meanwhile is not known: only threads above all "
               "others see that, and this user may not have them (SCHED_FIFO).";
    }
    if (seen->count == 0) return "The machine itself never stood still for 4 ms meanwhile.";
    std::array<char, 120> text{};
    std::snprintf(text.data(), text.size(),
                  "The machine itself stood still %llu times for 4 ms or longer meanwhile, for "
                  "%.1f ms at most.",
                  static_cast<unsigned long long>(seen->count),
                  std::chrono::duration<double, std::milli>(seen->longest).count());
    return text.data();
}

}  // namespace romano::bench
