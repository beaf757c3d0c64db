#include "broker/core/lifecycle.h"

#include "broker/core/session_deadline.h"
#include "romano/mqttsn/cell.h"

namespace romano::broker {

Session* Lifecycle::create(std::string_view client_id, Turn& turn) {
    if (tables_.sessions.size() >= tables_.limits().sessions && !make_room(turn)) return nullptr;
    Session& session = tables_.sessions.create(client_id);
    session.read_by_owner = client_id == tables_.options.read_by_owner;
    session.heard_at = turn.now;
    return &session;
}

bool Lifecycle::make_room(Turn& turn) {
    SessionTable& sessions = tables_.sessions;
    Session* first = sessions.departed_first();
    if (first == nullptr) first = sessions.displaced_first();
    if (first == nullptr) {
        const auto absent = sessions.absent().first_of_most();
        if (!absent) return false;
        first = sessions.at(*absent);
    }
    forget(*first, turn);
    return true;
}

/// Who is connected as far as anybody knows is lost first: its will is said.
void Lifecycle::forget(Session& session, Turn& turn) {
    if (session.is_connected()) depart_lost(session, turn);
    if (!session.header.clean) ++tables_.counters.sessions_forgotten;
    erase(session, turn.out);
}

void Lifecycle::heed_limit_of_absent(const Session& session, Turn& turn) {
    const AbsentSessions& absent = tables_.sessions.absent();
    if (absent.count_beside(session) <= tables_.limits().kept_per_address) return;
    forget(*tables_.sessions.at(*absent.first_beside(session)), turn);
}

void Lifecycle::wipe(Session& session) {
    subscriptions_.leave_all(session);
    session.subscriptions.clear();
    session.topics = {};
    session.queue.clear();
    session.unreleased.clear();
    session.retained_to_come.clear();
    session.worked_ahead.clear();
    session.awaited.clear();
    session.begun.clear();
    session.unfinished = mqttsn::no_msg_id;
    session.owes_pingresp = false;
    session.will.reset();
    session.exchange = {};
    session.pauses.clear();
    session.late_answer = {};
    session.ignores_register = false;
    session.held = false;
}

void Lifecycle::erase(Session& session, Actions& out) {
    tables_.log.append(out, [&] { return SessionErased{session.header.client_id}; });
    forget(session);
}

void Lifecycle::forget(Session& session) {
    subscriptions_.leave_all(session);
    tables_.deadlines.remove(session.number);
    tables_.sessions.erase(session);
}

bool Lifecycle::move(Session& session, const Origin& place, Turn& turn) {
    if (session.reachable && session.is_at(place)) return false;
    const SessionHeader& header = session.header;
    const bool is_somebody_else = header.via.packets != place.via.packets ||
                                  header.address.wireless_node_id != place.from.wireless_node_id;
    Session* previous = tables_.sessions.map(session, place, turn.now);
    if (is_somebody_else) subscriptions_.enter_all(session);  // with the rights of that one
    if (previous == nullptr) return true;
    // Its place has a new owner; it runs into its keep-alive and is sent nothing (G7).
    previous->exchange = {};
    if (previous->is_connected()) log_header(*previous, turn);
    schedule(tables_, *previous);
    if (!previous->header.clean) heed_limit_of_absent(*previous, turn);
    return true;
}

void Lifecycle::settle_at(Session& session, const Origin& place, Turn& turn) {
    const Session* owner = tables_.sessions.find(place);
    const bool has_lost_it = owner != nullptr && owner != &session &&
                             owner->header.last_heard > session.header.last_heard;
    if (has_lost_it || !has_place(place.from)) {
        tables_.sessions.displace(session, turn.now);
    } else {
        move(session, place, turn);
    }
}

void Lifecycle::sleep(Session& session, std::uint16_t duration_s, Turn& turn) {
    session.exchange = {};
    session.header.state = SessionState::asleep;
    session.header.sleep_s = duration_s;
    log_header(session, turn);
    schedule(tables_, session);
}

void Lifecycle::wake(Session& session, Turn& turn) {
    session.header.state = SessionState::awake;
    log_header(session, turn);
}

void Lifecycle::disconnect(Session& session, Turn& turn) {
    depart(session, SessionState::disconnected, turn);
    subscriptions_.remove(session, mqttsn::cell_topic, turn);  // it listens no more (cell.h)
    log_header(session, turn);
    if (!session.header.clean) heed_limit_of_absent(session, turn);
}

void Lifecycle::lose(Session& session, Turn& turn) {
    depart_lost(session, turn);
    if (!session.header.clean) heed_limit_of_absent(session, turn);
}

void Lifecycle::depart_lost(Session& session, Turn& turn) {
    depart(session, SessionState::lost, turn);
    const bool has_will = session.will && !session.will->topic.empty();
    if (!has_will || !enforcement_.may_say_will(speaker_of(session), *session.will, turn)) {
        log_header(session, turn);
    } else {
        publish_will(session, turn);
    }
}

/// One event for both, so that no heir finds the session lost and the will unsaid. A will of QoS 0
/// is in no log, like all of QoS 0.
void Lifecycle::publish_will(Session& session, Turn& turn) {
    const Will will = *session.will;
    const Publication publication =
        router_.admitted({will.topic, will.message, will.qos, will.retain});
    if (!Router::is_logged(publication)) log_header(session, turn);
    router_.find_receivers(publication, turn);
    router_.accept(publication, nullptr, mqttsn::no_msg_id, turn, session.header.client_id);
    router_.deliver(publication, turn);
}

void Lifecycle::depart(Session& session, SessionState state, Turn& turn) {
    session.exchange = {};
    session.late_answer = {};
    session.header.state = state;
    session.header.departed = tables_.clock.reading(turn.now);
    session.fresh = session.fresh_will = false;
    tables_.sessions.depart(session, turn.now);
    schedule(tables_, session);
}

void Lifecycle::log_header(const Session& session, Turn& turn, bool forgets_topics) {
    tables_.log.append(turn.out, [&] { return SessionChanged{session.header, forgets_topics}; });
}

}  // namespace romano::broker
