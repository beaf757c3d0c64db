// What a running process has used so far, as the kernel counts it: proc(5), stat and status.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string_view>

namespace romano::experiments {

struct ProcessUsage {
    double cpu_s = 0;         // user and system time of all its threads
    double rss_mib = 0;       // VmRSS
    double rss_peak_mib = 0;  // VmHWM
};

/// Empty when there is no such process, or it has ended.
[[nodiscard]] std::optional<ProcessUsage> usage_of(pid_t pid);

/// The same from the files' texts.
[[nodiscard]] std::optional<ProcessUsage> parse_usage(std::string_view stat,
                                                      std::string_view status, long ticks_per_s);

}  // namespace romano::experiments
