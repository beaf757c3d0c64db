#include "broker/core/invariants.h"

#include <algorithm>
#include <cassert>

#include "broker/core/session_deadline.h"

namespace romano::broker {
namespace {

[[maybe_unused]] void check_session(const Session& session, const Tables& tables) {
    [[maybe_unused]] const SessionTable& sessions = tables.sessions;
    assert(sessions.find(session.header.client_id) == &session);
    assert(sessions.at(session.number) == &session);
    assert(!session.reachable ||
           sessions.find(Origin{session.header.via, session.header.address}) == &session);
    assert(session.is_connected() == (session.departed_at == never));
    assert(session.displaced_at == never || (!session.reachable && session.is_connected()));

    // An exchange is about the queue's current message, and only with a client that listens.
    assert(!session.exchange.is_open() || !session.queue.empty());
    assert(!session.exchange.is_open() || session.is_listening());
    std::size_t place = 0;
    for ([[maybe_unused]] const Delivery& delivery : session.queue) {
        assert(delivery.message);
        assert(delivery.stage == DeliveryStage::queued || place == session.queue.place());
        assert((delivery.stage == DeliveryStage::queued) == (delivery.msg_id == mqttsn::no_msg_id));
        ++place;
    }
    assert(session.queue.size() <= tables.limits().queued_per_session);
    assert(session.unreleased.size() <= tables.limits().unreleased_per_session);
    assert(session.topics.size() <= tables.limits().topics_per_session);
    assert(session.output_floor <= tables.log.last());
    (void)place;
}

}  // namespace

void check_invariants(const Tables& tables) {
    std::size_t subscriptions = 0;
    std::size_t seen = 0;
    std::size_t connected = 0;
    tables.sessions.visit([&](const Session& session) {
        check_session(session, tables);
        subscriptions += session.subscriptions.size();
        connected += session.is_connected() ? 1U : 0U;
        ++seen;
    });
    assert(seen == tables.sessions.size());
    assert(connected == tables.sessions.connected());
    assert(subscriptions == tables.subscribers.size());
    assert(tables.retained.size() <= tables.limits().retained_messages);
    (void)subscriptions;
    (void)seen;
    (void)connected;
}

}  // namespace romano::broker
