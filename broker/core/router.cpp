#include "broker/core/router.h"

#include <algorithm>
#include <string>
#include <utility>

namespace romano::broker {

using mqttsn::MsgId;
using mqttsn::Qos;
using mqttsn::TopicIdType;

namespace {

/// Messages of one log come in order: once one is beyond, the session is ahead no more. Position 0
/// is no position: the message is in no log.
bool was_ahead(Session& session, const LogPosition& position) {
    const auto done = std::ranges::find(session.worked_ahead, position.log, &LogPosition::log);
    if (done == session.worked_ahead.end() || position.seq == 0) return false;
    if (position.seq <= done->seq) return true;
    session.worked_ahead.erase(done);
    return false;
}

/// A sleeper's QoS 0 waits, and that of a client that must learn an id first.
bool waits_with_qos0(const Session& session) {
    return session.is_connected();
}

}  // namespace

Publication Router::admitted(Publication publication) {
    const auto never_retained = tables_.options.never_retained;
    if (publication.retain && never_retained != nullptr &&
        never_retained(publication.topic, publication.payload)) {
        tables_.count(Drop::never_retained);
        publication.retain = false;
    }
    return publication;
}

void Router::retain(const MessagePtr& message) {
    const auto never_retained = tables_.options.never_retained;
    if (never_retained != nullptr && never_retained(message->topic, message->payload)) {
        tables_.count(Drop::never_retained);
    } else {
        tables_.retained.put(message);
    }
}

/// It was in the session's queue before, by its position alone: now it joins as if it were new, but
/// for the id under which it may have been sent.
bool Router::was_awaited(Session& session, const LogPosition& position, Turn& turn) {
    const auto awaited = std::ranges::find(session.awaited, position, &Delivery::position);
    if (awaited == session.awaited.end()) return false;
    if (awaited->msg_id != mqttsn::no_msg_id) session.begun.push_back({position, awaited->msg_id});
    session.awaited.erase(awaited);
    tables_.log.append(turn.out, [&] { return DeliveryEnded{session.header.client_id, position}; });
    return true;
}

void Router::find_receivers(const Publication& publication, const LogPosition& position,
                            Turn& turn) {
    receivers_.clear();
    repeatable_ = 0;
    ++fan_out_;
    tables_.subscribers.match(publication.topic, [&](SessionNumber number, const Grant& grant) {
        Session& session = *tables_.sessions.at(number);
        if (session.read_by_owner && !publication.origin.empty()) return;
        const Qos granted = std::min(publication.qos, grant.qos);
        if (session.matched_in == fan_out_) {  // overlapping filters: the highest QoS [3.3.5-1]
            Receiver& receiver = receivers_[session.matched_at];
            receiver.qos = std::max(receiver.qos, granted);
            return;
        }
        if (!session.worked_ahead.empty() && !was_awaited(session, position, turn) &&
            was_ahead(session, position)) {
            return;
        }
        if (grant.is_partial && !enforcement_.may_deliver(session, publication.topic)) return;
        session.matched_in = fan_out_;
        session.matched_at = static_cast<std::uint32_t>(receivers_.size());
        receivers_.push_back({&session, granted, grant.topic, false});
    });
}

std::size_t Router::longest_queue(const Session& publisher, std::string_view topic,
                                  Instant now) const {
    const Audience* peers = tables_.peers;
    const Instant since = now - tables_.options.t_retry;
    std::size_t most = peers == nullptr ? 0 : peers->longest_queue(topic, since);
    for (const Receiver& receiver : receivers_) {
        const Session& session = *receiver.session;
        if (receiver.qos == Qos::at_most_once || &session == &publisher) continue;
        // What waits at QoS 0 makes room.
        const std::size_t waiting = session.queue.size() - session.queue.unlogged();
        if (waiting > most && session.is_answering(since)) most = waiting;
    }
    return most;
}

void Router::claim_room() {
    for (Receiver& receiver : receivers_) {
        if (receiver.qos == Qos::at_most_once) continue;
        receiver.takes =
            receiver.session->keeps_messages() && deliveries_.make_room(*receiver.session);
    }
}

std::vector<Route> Router::routes() const {
    std::vector<Route> found;
    for (const Receiver& receiver : receivers_) {
        if (receiver.takes) {
            found.push_back({receiver.session->header.client_id, receiver.qos, false});
        }
    }
    return found;
}

void Router::accept(const Publication& publication, Session* publisher, MsgId msg_id, Turn& turn,
                    const ClientId& will_of) {
    claim_room();
    message_ = {};
    if (!publication.retain && !tables_.log.writes()) return;

    const bool in_log = is_logged(publication);
    const Audience* peers = tables_.peers;
    if (!in_log && peers != nullptr && !peers->wants(publication.topic)) return;
    message_ = make_message(publication, in_log, turn);
    if (!in_log) {
        turn.out.push(Forward{message_});
        return;
    }
    // By that a mirror knows that it was heard: it shall not know of more than its home.
    if (publisher != nullptr) publisher->header.last_heard = message_->published_at;
    tables_.log.append(turn.out, [&] {
        return Published{message_, publisher == nullptr ? ClientId{} : publisher->header.client_id,
                         msg_id, routes(), will_of};
    });
    if (publication.retain) tables_.retained.put(message_);
}

MessagePtr Router::make_message(const Publication& publication, bool in_log, Turn& turn) {
    const LogPosition unlogged{tables_.log.id(), 0};
    return MessagePtr{Message{.topic = std::string{publication.topic},
                              .payload = {publication.payload.begin(), publication.payload.end()},
                              .qos = publication.qos,
                              .retain = publication.retain,
                              .position = in_log ? tables_.log.next_position() : unlogged,
                              .published_at = tables_.clock.stamp(turn.now),
                              .origin = std::string{publication.origin}}};
}

void Router::tell_owner(const Publication& publication, Turn& turn) {
    if (!message_) message_ = make_message(publication, false, turn);
    turn.out.push(ForOwner{message_});
}

void Router::serve_cell(const Publication& publication, std::vector<Receiver>& receivers,
                        Turn& turn) {
    if (!cell_.takes(publication.topic, publication.qos)) return;
    const bool is_kept = publication.qos == Qos::at_least_once;
    if (is_kept && !message_) message_ = make_message(publication, false, turn);
    cell_.deliver(publication.topic, publication.payload, publication.qos, message_, receivers,
                  turn);
}

void Router::deliver(const Publication& publication, Turn& turn) {
    // Sending may not change who receives: the list is taken out for its time.
    std::vector<Receiver> receivers = std::exchange(receivers_, {});
    if (!publication.origin.empty()) tell_owner(publication, turn);
    serve_cell(publication, receivers, turn);
    for (const Receiver& receiver : receivers) {
        if (receiver.at_cell) continue;
        Session& session = *receiver.session;
        if (receiver.qos == Qos::at_most_once) {
            if (session.read_by_owner) {
                tell_owner(publication, turn);
                continue;
            }
            WireTopic topic = receiver.topic;
            if (deliveries_.can_send_at_once(session, topic, publication.topic)) {
                send_at_once(receiver, topic, publication, turn);
                continue;
            }
            if (!waits_with_qos0(session)) continue;
            if (tables_.full) {
                tables_.count(Drop::no_room);
                continue;
            }
            if (!deliveries_.make_room(session)) continue;
        } else if (!receiver.takes) {
            continue;
        }
        if (!message_) message_ = make_message(publication, false, turn);
        deliveries_.enqueue(
            session, {.position = message_->position, .message = message_, .qos = receiver.qos},
            turn);
    }
    receivers.clear();
    receivers_ = std::move(receivers);
    message_ = {};
}

void Router::send_at_once(const Receiver& receiver, const WireTopic& topic,
                          const Publication& publication, Turn& turn) {
    if (turn.out.is_full()) {
        tables_.count(Drop::output_full);
        return;
    }
    Session& session = *receiver.session;
    const bool wrapped = !session.header.address.wireless_node_id.empty();
    const std::uint64_t looks = 1U << 31U | static_cast<std::uint64_t>(topic.type) << 16U |
                                static_cast<std::uint64_t>(topic.id);
    if (!wrapped && looks == repeatable_) {
        outbox_.repeat(session, repeated_, turn);
        ++tables_.counters.publishes_sent;
        return;
    }
    const bool sent = outbox_.send(session,
                                   mqttsn::Publish{.dup = false,
                                                   .qos = Qos::at_most_once,
                                                   .retain = false,
                                                   .topic_type = topic.type,
                                                   .topic = topic.id,
                                                   .msg_id = mqttsn::no_msg_id,
                                                   .data = publication.payload},
                                   Gate::open, turn);
    repeatable_ = sent && !wrapped ? looks : 0;
    if (sent) {
        repeated_ = Outbox::last_sent(turn);
        ++tables_.counters.publishes_sent;
    } else {
        tables_.count(Drop::too_large);
    }
}

void Router::on_peer_message(const MessagePtr& message, Turn& turn) {
    const bool in_log = message->position.seq != 0;
    if (in_log && !tables_.cursors.advance(message->position)) return;
    tables_.clock.observe(message->published_at);
    if (message->retain) retain(message);

    const Publication publication{message->topic, message->payload, message->qos, message->retain,
                                  message->origin};
    find_receivers(publication, message->position, turn);
    claim_room();
    if (std::ranges::any_of(receivers_, &Receiver::takes)) {
        tables_.log.append(turn.out, [&] { return Routed{message->position, routes()}; });
        tables_.cursors.logged(message->position);
    }
    message_ = message;
    deliver(publication, turn);
}

void Router::set_system_topic(std::string_view topic, Bytes payload, Turn& turn) {
    const Publication publication{topic, payload, Qos::at_most_once, true};
    message_ = make_message(publication, false, turn);
    tables_.retained.put(message_);
    find_receivers(publication, {}, turn);
    deliver(publication, turn);
}

void Router::send_retained(Session& session, const Subscription& subscription, Turn& turn) {
    std::erase_if(session.retained_to_come, [&](const RetainedToCome& earlier) {
        return earlier.subscription.filter == subscription.filter;
    });
    RetainedToCome all{subscription, {}};
    if (!send_retained_behind(session, all, turn)) session.retained_to_come.push_back(all);
}

void Router::send_more_retained(Session& session, Turn& turn) {
    while (!session.retained_to_come.empty() &&
           send_retained_behind(session, session.retained_to_come.front(), turn)) {
        session.retained_to_come.erase(session.retained_to_come.begin());
    }
}

/// False when there is no more room for now.
bool Router::send_retained_behind(Session& session, RetainedToCome& rest, Turn& turn) {
    const Subscription& subscription = rest.subscription;
    const std::size_t most = (tables_.limits().queued_per_session + 1) / 2;
    const auto send = [&](const MessagePtr& message) {
        if (!enforcement_.may_deliver(session, message->topic)) return true;
        const Qos qos = std::min(message->qos, subscription.granted);
        if (session.read_by_owner) {
            if (!message->origin.empty()) return true;
            if (qos == Qos::at_most_once) {
                turn.out.push(ForOwner{message});
                return true;
            }
        }
        if (session.queue.size() >= most) return false;
        rest.after = message->topic;
        if (qos != Qos::at_most_once) {
            tables_.log.append(turn.out, [&] {
                return Routed{message->position, {{session.header.client_id, qos, true}}};
            });
        }
        deliveries_.enqueue(
            session,
            {.position = message->position, .message = message, .qos = qos, .retain = true}, turn);
        return true;
    };
    return tables_.retained.match(subscription.filter, send, rest.after);
}

}  // namespace romano::broker
