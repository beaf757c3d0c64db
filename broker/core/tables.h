// What the procedures of the broker core share: its tables, its log, its clock. No behaviour.
#pragma once

#include <cstdint>
#include <functional>

#include "broker/core/actions.h"
#include "broker/core/audience.h"
#include "broker/core/counters.h"
#include "broker/core/cursors.h"
#include "broker/core/deadlines.h"
#include "broker/core/hybrid_time.h"
#include "broker/core/limits.h"
#include "broker/core/log_writer.h"
#include "broker/core/notes.h"
#include "broker/core/permissions.h"
#include "broker/core/retained_store.h"
#include "broker/core/session_table.h"
#include "broker/core/topic_tree.h"
#include "romano/base/random.h"
#include "romano/base/time.h"

namespace romano::broker {

/// One call of the core: the time that it is told, and where its actions go.
struct Turn {
    Instant now;
    Actions& out;
};

/// What a session was granted for one filter. A plain filter's topic is known beforehand.
struct Grant {
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;
    WireTopic topic;
    bool is_partial =
        false;  // of its topics the client may not read all: each message is asked for
};

using Subscribers = TopicTree<SessionNumber, Grant>;

struct Tables {
    Tables(const BrokerOptions& given, std::uint64_t seed)
        : options(given),
          log(given.log, given.writes_log),
          clock(given.unix_time_at_zero),
          random(seed),
          retained(given.limits.retained_messages, given.writes_log) {}

    BrokerOptions options;
    LogWriter log;
    HybridClock clock;
    Random random;
    SessionTable sessions;
    Deadlines deadlines;
    Subscribers subscribers;
    RetainedStore retained;
    Cursors cursors;
    Counters counters;
    Notes notes;
    const Audience* peers = nullptr;           // null: they may want everything
    const Permissions* permissions = nullptr;  // null: everybody may do everything
    std::function<bool(const SessionHeader&, Instant)> is_silent;  // empty: nobody is
    bool congested = false;  // no new promises (BrokerCore::set_congested)
    bool full = false;       // nothing more that stays (BrokerCore::set_full)

    void count(Drop reason) { ++counters.dropped[static_cast<std::size_t>(reason)]; }
    [[nodiscard]] const Limits& limits() const { return options.limits; }
};

}  // namespace romano::broker
