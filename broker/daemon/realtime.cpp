#include "broker/daemon/realtime.h"

#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "broker/daemon/refusal.h"

namespace romano::daemon {
namespace {

// Above what people start by hand, below what the system may have for itself.
constexpr int priority = 20;

[[noreturn]] void refuse(const std::string& what) {
    throw Refusal("--realtime: " + what + " is not permitted (" + std::strerror(errno) +
                  "); give this user CAP_SYS_NICE and CAP_IPC_LOCK, or the limits rtprio and "
                  "memlock, or leave it out");
}

}  // namespace

void become_realtime() {
    sched_param parameters{};
    parameters.sched_priority = priority;
    if (sched_setscheduler(0, SCHED_RR, &parameters) != 0) refuse("SCHED_RR");
    // As pages are touched: the stacks of all threads in full would be tens of megabytes.
    if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) refuse("to lock memory");
}

}  // namespace romano::daemon
