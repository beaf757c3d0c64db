#include "experiments/load/ready_sockets.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <string>

#include "broker/net/clock.h"

namespace romano::experiments {

std::span<const epoll_event> wait_for_sockets(int epoll, Instant until,
                                              std::span<epoll_event> room) {
    const Duration patience = std::max(until - net::now(), Duration{0});
    const timespec wait{.tv_sec = patience / std::chrono::seconds{1},
                        .tv_nsec = (patience % std::chrono::seconds{1}).count()};
    const int most = static_cast<int>(room.size());
    int count = ::epoll_pwait2(epoll, room.data(), most, &wait, nullptr);
    if (count < 0 && errno == ENOSYS) {  // before Linux 5.11, and in qemu-user: in two steps
        pollfd any{.fd = epoll, .events = POLLIN, .revents = 0};
        (void)::ppoll(&any, 1, &wait, nullptr);
        count = ::epoll_wait(epoll, room.data(), most, 0);
    }
    if (count < 0 && errno != EINTR) {
        throw std::runtime_error(std::string{"cannot wait for sockets: "} + std::strerror(errno));
    }
    return room.first(static_cast<std::size_t>(std::max(count, 0)));
}

}  // namespace romano::experiments
