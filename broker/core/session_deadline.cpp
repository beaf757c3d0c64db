#include "broker/core/session_deadline.h"

#include <algorithm>

namespace romano::broker {
namespace {

Duration tolerated(std::uint16_t seconds, const BrokerOptions& options) {
    const auto exact = std::chrono::duration<double>{seconds} * options.keep_alive_tolerance;
    return std::chrono::duration_cast<Duration>(exact);
}

}  // namespace

Instant lost_at(const Session& session, const BrokerOptions& options) {
    const SessionHeader& header = session.header;
    if (header.state == SessionState::active && header.keep_alive_s != 0) {
        const std::uint16_t silence = std::max(header.keep_alive_s, header.sleep_s);  // in doubt
        return session.heard_at + tolerated(silence, options);
    }
    if (header.state == SessionState::asleep || header.state == SessionState::awake) {
        return session.heard_at + tolerated(header.sleep_s, options);
    }
    return never;
}

Instant probed_at(const Session& session, const BrokerOptions& options) {
    if (session.header.state != SessionState::active || session.header.keep_alive_s == 0) {
        return never;
    }
    const Instant silent_at = session.heard_at + std::chrono::seconds{session.header.keep_alive_s};
    const Instant at =
        session.probe_at == never ? silent_at : std::max(silent_at, session.probe_at);
    // One that may be asleep after all, having answered nothing so far, is left alone from then on.
    return at < session.heard_at + tolerated(session.header.keep_alive_s, options) ? at : never;
}

Instant forgotten_at(const Session& session, const BrokerOptions& options) {
    if (session.departed_at == never || session.read_by_owner) return never;
    if (session.header.clean) return session.departed_at + options.clean_session_kept_for;
    const std::chrono::seconds expiry{options.limits.session_expiry_s};
    return expiry == expiry.zero() ? never : session.departed_at + expiry;
}

Instant due_at(const Session& session, const BrokerOptions& options) {
    Instant due =
        std::min({lost_at(session, options), probed_at(session, options), session.late_answer.at});
    if (session.exchange.is_open() && !session.exchange.stalled) {
        due = std::min(due, session.exchange.retry_at);
    }
    if (!session.queue.empty() && session.is_listening()) {
        for (const Pause& pause : session.pauses) due = std::min(due, pause.until);
    }
    return std::min(due, forgotten_at(session, options));
}

}  // namespace romano::broker
