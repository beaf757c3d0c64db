#include "overlay/cluster/messages.h"

#include <algorithm>

namespace romano::cluster {

bool View::contains(const LogId& log) const {
    return std::ranges::binary_search(members, log);
}

bool View::has_later_life_of(const LogId& log) const {
    const auto next = std::ranges::upper_bound(members, log);
    return next != members.end() && next->broker == log.broker;
}

std::optional<Seq> Beacon::held_of(const LogId& other) const {
    const auto found = std::ranges::lower_bound(applied, other, {}, &LogPosition::log);
    if (found == applied.end() || found->log != other) return std::nullopt;
    return found->seq;
}

bool Beacon::hears_from(BrokerId broker) const {
    return std::ranges::binary_search(hears, broker);
}

std::optional<Seq> Beacon::end_of(const LogId& of) const {
    return broker::seq_of(ended, of);
}

Delivery delivery_of(const ClusterMessage& message) {
    if (std::holds_alternative<Heartbeat>(message)) return Delivery::beacon;
    if (std::holds_alternative<Pulse>(message)) return Delivery::beacon;
    if (std::holds_alternative<LogBatch>(message)) return Delivery::log;
    if (std::holds_alternative<SecuredTold>(message)) return Delivery::log;
    if (std::holds_alternative<ForwardBatch>(message)) return Delivery::best_effort;
    return Delivery::direct;
}

std::optional<Pulse> pulse_after(const ClusterMessage& message) {
    if (const auto* pulse = std::get_if<Pulse>(&message)) return *pulse;
    const auto* heartbeat = std::get_if<Heartbeat>(&message);
    if (heartbeat == nullptr || heartbeat->leaving) return std::nullopt;
    return Pulse{heartbeat->log, heartbeat->tick};
}

}  // namespace romano::cluster
