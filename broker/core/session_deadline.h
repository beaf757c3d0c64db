// When a session must be looked at next: retries, keep-alive, sleep, and the end of a
// session that was left behind (MQTT-SN 1.2 sections 6.11, 6.14, 7.2; G5, G6, G11).
#pragma once

#include "broker/core/session.h"
#include "broker/core/tables.h"
#include "romano/base/time.h"

namespace romano::broker {

/// When the client counts as lost if nothing comes: keep-alive or sleep duration with tolerance.
[[nodiscard]] Instant lost_at(const Session& session, const BrokerOptions& options);

/// When a client that is silent for its keep-alive is asked for a sign of life first.
[[nodiscard]] Instant probed_at(const Session& session, const BrokerOptions& options);

/// When what was left behind is forgotten: a clean session, or a kept one with an expiry.
[[nodiscard]] Instant forgotten_at(const Session& session, const BrokerOptions& options);

[[nodiscard]] Instant due_at(const Session& session, const BrokerOptions& options);

inline void schedule(Tables& tables, const Session& session) {
    tables.deadlines.no_later_than(session.number, due_at(session, tables.options));
}

}  // namespace romano::broker
