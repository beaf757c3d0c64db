// Which sockets of an epoll set are ready: waits for them to the nanosecond, on every Linux.
#pragma once

#include <sys/epoll.h>

#include <span>

#include "romano/base/time.h"

namespace romano::experiments {

/// Those that are, at the front of `room`; none when none was until `until`. Throws
/// std::runtime_error with a sentence.
std::span<const epoll_event> wait_for_sockets(int epoll, Instant until,
                                              std::span<epoll_event> room);

}  // namespace romano::experiments
