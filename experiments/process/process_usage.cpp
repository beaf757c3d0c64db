#include "experiments/process/process_usage.h"

#include <unistd.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace romano::experiments {
namespace {

std::string read_file(const std::string& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

std::optional<ProcessUsage> parse_usage(std::string_view stat, std::string_view status,
                                        long ticks_per_s) {
    // The second field is the program's name in parentheses; it may hold spaces and parentheses.
    const std::size_t name_end = stat.rfind(')');
    const std::size_t peak = status.find("VmHWM:");
    if (name_end == std::string_view::npos || peak == std::string_view::npos) return std::nullopt;
    std::istringstream fields{std::string{stat.substr(name_end + 1)}};
    std::string skipped;
    for (int field = 3; field < 14; ++field) fields >> skipped;
    double user_ticks = 0;
    double system_ticks = 0;
    fields >> user_ticks >> system_ticks;  // fields 14 and 15

    std::istringstream peak_field{std::string{status.substr(peak + 6)}};
    double peak_kib = 0;
    peak_field >> peak_kib;
    if (!fields || !peak_field) return std::nullopt;
    return ProcessUsage{(user_ticks + system_ticks) / static_cast<double>(ticks_per_s),
                        peak_kib / 1024};
}

std::optional<ProcessUsage> usage_of(pid_t pid) {
    const std::string folder = "/proc/" + std::to_string(pid);
    return parse_usage(read_file(folder + "/stat"), read_file(folder + "/status"),
                       ::sysconf(_SC_CLK_TCK));
}

}  // namespace romano::experiments
