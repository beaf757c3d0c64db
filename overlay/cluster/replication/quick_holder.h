// Who acknowledges a log at once. The `acks` + 1 members that come next after its writer, by id and
// around: one more than its clients wait for, so that a slow one delays nobody. The others' beacons
// say the same a little later. If all acknowledged at once, then each message would cost each
// broker more with every broker that joins.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "broker/core/log_position.h"

namespace romano::cluster {

/// `living`: members of the view that `self` hears.
[[nodiscard]] inline bool is_quick_holder(broker::BrokerId self, broker::BrokerId writer,
                                          std::span<const broker::LogId> living,
                                          std::uint32_t acks) {
    const auto steps_behind_writer = [writer](broker::BrokerId id) {
        return static_cast<std::uint64_t>(id) - static_cast<std::uint64_t>(writer);
    };
    const auto is_before_self = [&](const broker::LogId& member) {
        return member.broker != writer &&
               steps_behind_writer(member.broker) < steps_behind_writer(self);
    };
    const auto before = std::ranges::count_if(living, is_before_self);
    return static_cast<std::uint64_t>(before) <= acks;
}

}  // namespace romano::cluster
