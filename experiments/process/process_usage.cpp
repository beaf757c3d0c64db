#include "experiments/process/process_usage.h"

#include <unistd.h>

#include <sstream>
#include <string>

#include "experiments/process/process_file.h"

namespace romano::experiments {
namespace {

/// A line of status such as "VmHWM:     1234 kB".
std::optional<double> mib_of(std::string_view status, std::string_view field) {
    const std::size_t at = status.find(field);
    if (at == std::string_view::npos) return std::nullopt;
    std::istringstream line{std::string{status.substr(at + field.size())}};
    double kib = 0;
    return line >> kib ? std::optional{kib / 1024} : std::nullopt;
}

}  // namespace

std::optional<ProcessUsage> parse_usage(std::string_view stat, std::string_view status,
                                        long ticks_per_s) {
    // The second field is the program's name in parentheses; it may hold spaces and parentheses.
    const std::size_t name_end = stat.rfind(')');
    const auto rss = mib_of(status, "VmRSS:");
    const auto peak = mib_of(status, "VmHWM:");
    if (name_end == std::string_view::npos || !rss || !peak) return std::nullopt;
    std::istringstream fields{std::string{stat.substr(name_end + 1)}};
    std::string skipped;
    for (int field = 3; field < 14; ++field) fields >> skipped;
    double user_ticks = 0;
    double system_ticks = 0;
    fields >> user_ticks >> system_ticks;  // fields 14 and 15
    if (!fields) return std::nullopt;
    return ProcessUsage{(user_ticks + system_ticks) / static_cast<double>(ticks_per_s), *rss,
                        *peak};
}

std::optional<ProcessUsage> usage_of(pid_t pid) {
    return parse_usage(process_file(pid, "stat"), process_file(pid, "status"),
                       ::sysconf(_SC_CLK_TCK));
}

}  // namespace romano::experiments
