// What the file holds, as a broker core takes it in again: like a dead broker's mirror.
#pragma once

#include <cstdint>
#include <vector>

#include "broker/core/session_image.h"
#include "broker/store/database.h"

namespace romano::store {

struct StoredState {
    std::vector<broker::SessionImage> sessions;  // by client id
    std::vector<broker::MessagePtr> retained;    // by topic
};

/// Positions are given as those of `self`, whatever name the broker had when it wrote them.
[[nodiscard]] StoredState read_state(Database& database, broker::BrokerId self);

/// Highest incarnation of the log that is still referred to; the next life's must be higher.
[[nodiscard]] std::uint64_t last_incarnation(Database& database);

}  // namespace romano::store
