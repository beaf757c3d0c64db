#include "overlay/dds/peer_writers.h"

#include <array>
#include <cinttypes>
#include <cstdio>

namespace romano::dds {
namespace {

std::string topic_of(const char* kind, const broker::LogId& addressee) {
    std::array<char, 64> name{};
    std::snprintf(name.data(), name.size(), "romano_%s_%016" PRIx64 "_%016" PRIx64, kind,
                  static_cast<std::uint64_t>(addressee.broker), addressee.incarnation);
    return name.data();
}

}  // namespace

std::string inbox_topic(const broker::LogId& addressee) {
    return topic_of("inbox", addressee);
}
std::string forward_topic(const broker::LogId& addressee) {
    return topic_of("forward", addressee);
}

// Two brokers do not discover each other at the same moment. What one says before the other is
// ready to hear it waits, up to 64 messages.
Qos inbox_qos() {
    return reliable_for_late_readers(4096, 64);
}

Qos forward_qos() {
    return best_effort(1024);
}

}  // namespace romano::dds
