#include "overlay/daemon/low_descriptors.h"

#include <fcntl.h>
#include <sys/select.h>

#include <string>

#include "broker/daemon/refusal.h"

namespace romano::daemon {
namespace {

/// DDS opens about a dozen.
constexpr int needed = 64;

}  // namespace

void expect_low_descriptors() {
    int open = 0;
    for (int descriptor = 0; descriptor < FD_SETSIZE; ++descriptor) {
        if (::fcntl(descriptor, F_GETFD) >= 0) ++open;
    }
    if (open + needed <= FD_SETSIZE) return;
    throw Refusal(std::to_string(open) + " of the file descriptors below " +
                  std::to_string(FD_SETSIZE) +
                  " are open, inherited from what started this broker, and DDS needs " +
                  std::to_string(needed) +
                  " of them; have it close them (FD_CLOEXEC) before it starts a broker");
}

}  // namespace romano::daemon
