#include "broker/metrics/process_metrics.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <string>

namespace romano::metrics {
namespace {

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) * 1e-6;
}

/// /proc/self/statm: pages, total and resident.
double resident_octets() {
    std::ifstream statm("/proc/self/statm");
    std::uint64_t total = 0;
    std::uint64_t resident = 0;
    statm >> total >> resident;
    return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace

void add_process(Page& page, std::string_view broker_name, std::string_view version, double start) {
    page.gauge("romano_broker_info", "Which broker this is; always 1.", 1,
               {{"name", std::string{broker_name}}, {"version", std::string{version}}});
    page.gauge("process_start_time_seconds", "When the process began, since the Unix epoch.",
               start);
    page.gauge("process_resident_memory_bytes", "Resident memory.", resident_octets());
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    page.counter("process_cpu_seconds_total", "User and system CPU time.",
                 seconds(usage.ru_utime) + seconds(usage.ru_stime));
}

}  // namespace romano::metrics
