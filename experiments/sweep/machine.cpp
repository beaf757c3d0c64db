#include "experiments/sweep/machine.h"

#include <sys/sysinfo.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <fstream>
#include <string_view>
#include <thread>

namespace romano::experiments {
namespace {

/// The rest of the first line of `file` that begins with `key`, behind `separator`.
std::string value_of(const char* file, std::string_view key, char separator) {
    std::ifstream stream(file);
    std::string line;
    while (std::getline(stream, line)) {
        if (!line.starts_with(key)) continue;
        std::size_t from = line.find(separator);
        if (from == std::string::npos) continue;
        from = line.find_first_not_of(" \t\"", from + 1);
        if (from == std::string::npos) continue;
        const std::size_t to = line.find_last_not_of(" \t\"");
        return line.substr(from, to + 1 - from);
    }
    return "unknown";
}

}  // namespace

Machine this_machine() {
    Machine machine;
    machine.cpu = value_of("/proc/cpuinfo", "model name", ':');
    machine.cores = std::thread::hardware_concurrency();
    struct sysinfo memory = {};
    if (::sysinfo(&memory) == 0) {
        machine.memory_gib =
            static_cast<double>(memory.totalram) * memory.mem_unit / (1024.0 * 1024 * 1024);
    }
    if (::getloadavg(&machine.load_average, 1) < 1) machine.load_average = 0;
    utsname kernel{};
    if (::uname(&kernel) == 0) {
        machine.kernel = std::string{kernel.sysname} + " " + kernel.release + " " + kernel.machine;
    }
    machine.system = value_of("/etc/os-release", "PRETTY_NAME", '=');
    return machine;
}

}  // namespace romano::experiments
