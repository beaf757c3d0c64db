#include "overlay/dds/peer_writers.h"

#include <array>
#include <charconv>
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

std::optional<broker::LogId> addressee_of(std::string_view topic) {
    constexpr std::string_view inbox = "romano_inbox_";
    constexpr std::size_t digits = 16;
    if (topic.size() != inbox.size() + 2 * digits + 1 || !topic.starts_with(inbox)) {
        return std::nullopt;
    }
    const auto number_at = [&](std::size_t at) {
        std::uint64_t number = 0;
        const char* const first = topic.data() + at;
        const auto [end, error] = std::from_chars(first, first + digits, number, 16);
        const bool is_number = error == std::errc{} && end == first + digits;
        return is_number ? std::optional{number} : std::nullopt;
    };
    const auto broker = number_at(inbox.size());
    const auto incarnation = number_at(inbox.size() + digits + 1);
    if (!broker || !incarnation) return std::nullopt;
    return broker::LogId{broker::BrokerId{*broker}, *incarnation};
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
