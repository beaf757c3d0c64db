#include "broker/core/liveness.h"

#include <chrono>
#include <utility>

#include "broker/core/session_deadline.h"

namespace romano::broker {

using mqttsn::MsgType;

namespace {

/// A look that comes so late is no busy moment: the process stood still.
constexpr Duration stood_still_after = std::chrono::milliseconds{100};

/// From a sleeper: it collects its messages, or ends its sleep or changes it.
bool is_of_sleepers(MsgType type) {
    return type == MsgType::pingreq || type == MsgType::disconnect;
}

}  // namespace

void Liveness::on_heard(Session& session, const Origin& origin, MsgType type, Turn& turn) {
    session.heard_at = turn.now;
    session.probe_at = never;
    session.exchange.heard = session.exchange.heard_since = true;
    SessionHeader& header = session.header;
    header.last_heard = tables_.clock.stamp(turn.now);
    const bool has_moved = lifecycle_.move(session, origin, turn);
    if (!header.provisional && !has_moved) return;
    const bool is_first_word = std::exchange(header.provisional, false);
    if (is_first_word) ++header.epoch;  // heard at its new home: the session is ours now
    // A sleeper that speaks as the connected do has connected, it seems, at its former home, out of
    // our sight; also one that was awake when it was seen last. In doubt it keeps its sleeping
    // time: should it sleep, it will say so. One that is awake still waits for its PINGRESP, and
    // may not ask again while messages come: it gets it, which does a connected one no harm.
    const bool was_awake = header.state == SessionState::awake;
    const bool was_sleeper = was_awake || header.state == SessionState::asleep;
    const bool seems_connected = is_first_word && was_sleeper && !is_of_sleepers(type);
    if (seems_connected) {
        header.state = SessionState::active;
        session.owes_pingresp = was_awake;
    }
    lifecycle_.log_header(session, turn);
    if (seems_connected) deliveries_.go_on(session, turn);
}

void Liveness::on_pingreq(Session& session, const mqttsn::Pingreq& message, Turn& turn) {
    if (session.seems_connected() && !message.client_id.empty()) {  // no: it sleeps
        lifecycle_.sleep(session, session.header.sleep_s, turn);
    }
    switch (session.header.state) {
        case SessionState::asleep:
            if (session.queue.empty()) break;
            lifecycle_.wake(session, turn);
            deliveries_.go_on(session, turn);  // PINGRESP when nothing is left
            return;
        case SessionState::awake:
            if (deliveries_.repeat(session, turn)) return;
            break;
        default:
            break;
    }
    outbox_.send(session, mqttsn::Pingresp{}, Gate::open, turn);
}

void Liveness::on_disconnect(Session& session, const mqttsn::Disconnect& message, Turn& turn) {
    if (message.has_duration && message.duration_s != 0) {
        lifecycle_.sleep(session, message.duration_s, turn);
        outbox_.send(session, mqttsn::Disconnect{}, Gate::open, turn);
        return;
    }
    outbox_.send(session, mqttsn::Disconnect{}, Gate::open, turn);
    lifecycle_.disconnect(session, turn);
}

void Liveness::on_tick(const SessionJudgement& may_be_unheard, Turn& turn) {
    const bool stood_still = turn.now - stood_still_after >= tables_.deadlines.next();
    while (tables_.deadlines.next() <= turn.now) {
        Session* session = tables_.sessions.at(tables_.deadlines.pop());
        if (session == nullptr) continue;
        const bool is_unheard = may_be_unheard && may_be_unheard(session->header);
        look_at(*session, is_unheard, stood_still, turn);
    }
}

/// Does what is due, if anything is: deadlines that moved are found out here.
void Liveness::look_at(Session& session, bool is_unheard, bool stood_still, Turn& turn) {
    const BrokerOptions& options = tables_.options;
    if (forgotten_at(session, options) <= turn.now) {
        if (!session.header.clean) ++tables_.counters.sessions_expired;
        lifecycle_.erase(session, turn.out);
        return;
    }
    if (lost_at(session, options) <= turn.now) {
        if (!is_unheard && !stood_still) {
            lifecycle_.lose(session, turn);
            return;
        }
        session.heard_at = turn.now;
    }
    if (session.late_answer.at <= turn.now) publishes_.answer_what_is_owed(session, turn);
    if (probed_at(session, options) <= turn.now) {
        session.probe_at = turn.now + options.t_retry;
        if (session.reachable) outbox_.send(session, mqttsn::Pingreq{}, Gate::open, turn);
    }
    const Exchange& exchange = session.exchange;
    if (!exchange.is_open() || exchange.stalled || exchange.retry_at > turn.now) {
        deliveries_.end_pauses(session, turn);
    } else if (exchange.kind == Exchange::Kind::publishing &&
               (is_unheard || session.header.provisional)) {
        deliveries_.ask(session, turn);
    } else {
        deliveries_.on_retry(session, turn);
    }
    schedule(tables_, session);
}

}  // namespace romano::broker
