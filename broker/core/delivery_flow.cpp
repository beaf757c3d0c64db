#include "broker/core/delivery_flow.h"

#include <algorithm>
#include <string>
#include <utility>

#include "broker/core/session_deadline.h"
#include "romano/base/printable.h"

namespace romano::broker {

using mqttsn::MsgId;
using mqttsn::Qos;
using mqttsn::ReturnCode;
using mqttsn::TopicId;
using mqttsn::TopicIdType;
using Kind = Exchange::Kind;

namespace {

/// How long REGISTER may hold up a message of a name that the client subscribed to by itself: it
/// learnt the id from SUBACK, and what ignores REGISTER (emcute, asymcute) must not wait for long.
constexpr Duration courtesy{std::chrono::seconds{1}};

/// So often, or all the times of one round, a client must be there and pass a message over before
/// it is said not to take it: each single time the message or its answer may have been lost.
constexpr int often_enough = 8;

/// When a sending is over: the client was heard since, and the message is still open.
void count_pass(Exchange& exchange) {
    const bool was_sent = exchange.sendings != 0;  // to it alone, and it has no leave to wait
    const bool counts = was_sent && exchange.heard_since && exchange.kind != Kind::registering;
    if (counts && exchange.ignored < often_enough) ++exchange.ignored;
}

}  // namespace

bool DeliveryFlow::make_room(Session& session) {
    if (session.queue.size() < tables_.limits().queued_per_session) return true;
    tables_.count(Drop::queue_full);
    return session.queue.drop_oldest_unlogged(session.exchange.is_open());
}

void DeliveryFlow::on_read(Session& session, const LogPosition& position, Turn& turn) {
    if (!session.queue.erase(position)) return;
    tables_.log.append(turn.out, [&] { return DeliveryEnded{session.header.client_id, position}; });
}

void DeliveryFlow::enqueue(Session& session, Delivery delivery, Turn& turn) {
    session.queue.push(std::move(delivery));
    go_on(session, turn);
}

bool DeliveryFlow::can_send_at_once(Session& session, WireTopic& topic, std::string_view name) {
    if (session.header.state != SessionState::active || !session.reachable) return false;
    if (session.held || session.queue.unlogged() != 0) return false;
    if (topic.type != TopicIdType::normal) return true;
    if (topic.id == mqttsn::no_topic_id) {
        topic.id = session.topics.find(name);
        if (topic.id == mqttsn::no_topic_id) {
            if (name.size() != 2) return false;
            topic = {TopicIdType::short_name, TopicId{be16(as_octets(name), 0)}};
            return true;
        }
    }
    const TopicRegistry::Topic& entry = *session.topics.at(topic.id);
    return !entry.refused && (entry.known || session.ignores_register);
}

WireTopic DeliveryFlow::plain_topic(const Session& session, std::string_view name) {
    const Grant* grant = tables_.subscribers.find(name, session.number);
    return grant != nullptr ? grant->topic : WireTopic{};
}

DeliveryFlow::Readiness DeliveryFlow::prepare(Session& session, WireTopic& topic,
                                              std::string_view name, Turn& turn) {
    if (topic.type != TopicIdType::normal) return Readiness::ready;
    if (topic.id == mqttsn::no_topic_id) {
        topic.id = session.topics.find(name);
        if (topic.id == mqttsn::no_topic_id && name.size() == 2) {
            topic = {TopicIdType::short_name, TopicId{be16(as_octets(name), 0)}};
            return Readiness::ready;
        }
        if (topic.id == mqttsn::no_topic_id) {
            topic.id = subscriptions_.bind(session, name, false, turn);
        }
        if (topic.id == mqttsn::no_topic_id) {
            tables_.count(Drop::no_room);
            tables_.notes.say(turn.now, turn.out, [&] {
                return "client '" + printable(session.header.client_id) + "' has " +
                       std::to_string(session.topics.size()) +
                       " topic ids and can be given no more (max-topics): what comes on '" +
                       printable(name) + "' is dropped for this client";
            });
            return Readiness::impossible;
        }
    }
    const TopicRegistry::Topic& entry = *session.topics.at(topic.id);
    if (entry.refused) {
        tables_.count(Drop::refused_by_client);
        return Readiness::impossible;
    }
    return entry.known || session.ignores_register ? Readiness::ready : Readiness::must_register;
}

bool DeliveryFlow::is_silent(const Session& session, Instant now) const {
    return tables_.is_silent && tables_.is_silent(session.header, now);
}

void DeliveryFlow::go_on(Session& session, Turn& turn) {
    const bool would_begin = !session.exchange.is_open() && !session.queue.empty();
    if (would_begin && is_silent(session, turn.now)) return schedule(tables_, session);
    while (session.is_listening() && !session.held && !session.read_by_owner &&
           !session.exchange.is_open() && choose(session, turn.now)) {
        if (open_front(session, turn)) break;
    }
    const bool is_awake = session.header.state == SessionState::awake;
    const bool may_be_awake = session.owes_pingresp && session.seems_connected();
    if ((is_awake || may_be_awake) && !session.exchange.is_open()) {
        if (session.reachable) outbox_.send(session, mqttsn::Pingresp{}, Gate::open, turn);
        session.owes_pingresp = false;
        if (is_awake) fall_asleep(session, turn);
    }
    schedule(tables_, session);
}

bool DeliveryFlow::choose(Session& session, Instant now) {
    DeliveryQueue& queue = session.queue;
    if (queue.empty()) return false;
    if (queue.current().stage != DeliveryStage::queued) {
        return !is_paused(session, queue.current(), now);
    }
    std::size_t place = 0;
    for (const Delivery& delivery : queue) {
        if (!is_paused(session, delivery, now)) {
            queue.choose(place);
            return true;
        }
        ++place;
    }
    return false;
}

bool DeliveryFlow::is_paused(const Session& session, const Delivery& delivery, Instant now) {
    if (session.pauses.empty() || delivery.stage == DeliveryStage::released) return false;
    const std::string& name = delivery.message->topic;
    WireTopic topic = plain_topic(session, name);
    if (topic.type != TopicIdType::normal) return false;
    if (topic.id == mqttsn::no_topic_id) topic.id = session.topics.find(name);
    const auto pause = std::ranges::find(session.pauses, topic.id, &Pause::topic);
    return pause != session.pauses.end() && pause->until > now && !session.topics.knows(topic.id);
}

void DeliveryFlow::end_pauses(Session& session, Turn& turn) {
    const auto is_over = [&](const Pause& pause) { return pause.until <= turn.now; };
    if (std::erase_if(session.pauses, is_over) != 0) go_on(session, turn);
}

bool DeliveryFlow::open_front(Session& session, Turn& turn) {
    Delivery& delivery = session.queue.current();
    if (delivery.stage == DeliveryStage::released) {  // an adopted or resumed hand-shake
        open(session, Kind::releasing, delivery.msg_id, {});
        return send_open(session, true, turn);
    }
    // It may have waited for long, and its client may read less than before.
    if (!enforcement_.may_deliver(session, delivery.message->topic)) {
        end_front(session, turn);
        return false;
    }
    WireTopic topic = plain_topic(session, delivery.message->topic);
    switch (prepare(session, topic, delivery.message->topic, turn)) {
        case Readiness::impossible:
            end_front(session, turn);
            return false;
        case Readiness::must_register:
            open(session, Kind::registering, next_msg_id(session), topic);
            return send_open(session, false, turn);
        case Readiness::ready:
            break;
    }
    return publish_front(session, topic, turn);
}

bool DeliveryFlow::publish_front(Session& session, const WireTopic& topic, Turn& turn) {
    Delivery& delivery = session.queue.current();
    if (delivery.qos == Qos::at_most_once) {
        if (!send_publish(session, delivery, topic, false, turn)) tables_.count(Drop::too_large);
        session.queue.pop();
        session.exchange = {};
        return false;
    }
    const bool started = delivery.stage == DeliveryStage::published;
    const bool may_be_there =
        started || std::ranges::count(session.begun, delivery.position, &Begun::position) > 0;
    const bool again = may_be_there && !session.exchange.refused;  // a fall-back has a new msg id
    if (!started) {
        if (delivery.qos == Qos::exactly_once) release_unfinished(session, turn);
        if (delivery.qos == Qos::at_least_once && again) ++tables_.counters.cell_repairs;
        start(session, delivery, turn);
    }
    open(session, Kind::publishing, delivery.msg_id, topic);
    return send_open(session, again, turn);
}

/// What is known of the front's refusal stays: REGISTER may come before its second PUBLISH (G21).
/// So does how often it was passed over before the client slept, unless the client took a step.
void DeliveryFlow::open(Session& session, Kind kind, MsgId msg_id, const WireTopic& topic) {
    const std::uint8_t ignored = session.exchange.is_open() ? 0 : session.exchange.ignored;
    session.exchange = {.kind = kind,
                        .ignored = ignored,
                        .refused = session.exchange.refused,
                        .bare = session.exchange.bare,
                        .msg_id = msg_id,
                        .topic = topic};
}

/// Gives the delivery its msg id, which a QoS 2 PUBLISH must not leave without.
void DeliveryFlow::start(Session& session, Delivery& delivery, Turn& turn) {
    delivery.stage = DeliveryStage::published;
    delivery.msg_id = msg_id_for(session, delivery);
    tables_.log.append(turn.out, [&] {
        return DeliveryStarted{session.header.client_id, delivery.position, delivery.msg_id,
                               delivery.qos};
    });
}

/// False when the front was dropped because it fits no datagram (6.10f).
bool DeliveryFlow::send_open(Session& session, bool again, Turn& turn) {
    const Exchange& exchange = session.exchange;
    const Delivery& delivery = session.queue.current();
    bool sent = true;
    switch (exchange.kind) {
        case Kind::none:
            return false;
        case Kind::registering:
            sent = outbox_.send(session,
                                mqttsn::Register{.topic_id = exchange.topic.id,
                                                 .msg_id = exchange.msg_id,
                                                 .topic_name = delivery.message->topic},
                                Gate::logged, turn);
            break;
        case Kind::publishing:
            sent = send_publish(session, delivery, exchange.topic, again && !exchange.bare, turn);
            break;
        case Kind::releasing:
            sent = outbox_.send(session, mqttsn::Pubrel{exchange.msg_id}, Gate::logged, turn);
            break;
    }
    if (!sent) {
        drop_front(session, Drop::too_large, turn);
        return false;
    }
    supervise(session, turn);
    return true;
}

bool DeliveryFlow::send_publish(Session& session, const Delivery& delivery, const WireTopic& topic,
                                bool dup, Turn& turn) {
    const Gate gate = delivery.qos == Qos::exactly_once ? Gate::logged : Gate::open;
    const bool sent =
        outbox_.send(session,
                     mqttsn::Publish{.dup = dup,
                                     .qos = delivery.qos,
                                     .retain = delivery.retain && !session.exchange.bare,
                                     .topic_type = topic.type,
                                     .topic = topic.id,
                                     .msg_id = delivery.msg_id,
                                     .data = delivery.message->payload},
                     gate, turn);
    if (sent) ++tables_.counters.publishes_sent;
    return sent;
}

void DeliveryFlow::supervise(Session& session, Turn& turn) {
    Exchange& exchange = session.exchange;
    const Duration of_cell = std::exchange(exchange.cell_patience, Duration{0});
    if (of_cell != Duration{0}) ++tables_.counters.cell_repairs;
    if (++exchange.sendings > 1) {
        ++tables_.counters.retransmissions;
    } else {
        exchange.sent_at = turn.now;
    }
    exchange.heard_since = false;
    if (exchange.doubted) outbox_.send(session, mqttsn::Pingreq{}, Gate::open, turn);
    exchange.retry_at = turn.now + patience_with(session);
    schedule(tables_, session);
}

/// From one sending to the next.
Duration DeliveryFlow::patience_with(Session& session) {
    const Duration t_retry = tables_.options.t_retry;
    return names_known_id(session) ? std::min(t_retry, courtesy) : t_retry;
}

/// REGISTER is open for a name that the client subscribed to without wildcards.
bool DeliveryFlow::names_known_id(Session& session) {
    return session.exchange.kind == Kind::registering &&
           tables_.subscribers.find(session.queue.current().message->topic, session.number) !=
               nullptr;
}

void DeliveryFlow::on_regack(Session& session, const mqttsn::Regack& message, Turn& turn) {
    Exchange& exchange = session.exchange;
    if (exchange.kind != Kind::registering || exchange.msg_id != message.msg_id) {
        tables_.count(Drop::unexpected);
        return;
    }
    const TopicId id = exchange.topic.id;
    exchange.kind = Kind::none;
    if (message.return_code == ReturnCode::accepted) {
        subscriptions_.set_known(session, id, true, turn);
        session.ignores_register = false;
    } else if (message.return_code == ReturnCode::congestion) {
        std::erase_if(session.pauses, [id](const Pause& pause) { return pause.topic == id; });
        session.pauses.push_back({id, turn.now + tables_.options.t_wait});
    } else {  // nothing of that name until it subscribes or registers again (6.10b, G16)
        session.topics.refuse(id);
        subscriptions_.remove(session, session.topics.at(id)->name, turn);
    }
    go_on(session, turn);
}

void DeliveryFlow::on_puback(Session& session, const mqttsn::Puback& message, Turn& turn) {
    const Exchange& exchange = session.exchange;
    if (exchange.kind != Kind::publishing || exchange.msg_id != message.msg_id) {
        const std::size_t behind = behind_front_at_cell(session, message.msg_id);
        if (behind != 0 && message.return_code == ReturnCode::accepted) {
            end_at_cell(session, behind, turn);
        } else if (message.msg_id == mqttsn::no_msg_id &&
                   message.return_code == ReturnCode::invalid_topic_id) {
            subscriptions_.set_known(session, message.topic_id, false, turn);  // of QoS 0 (G21)
        } else {
            tables_.count(Drop::unexpected);
        }
        return;
    }
    const Delivery& delivery = session.queue.current();
    if (message.return_code == ReturnCode::accepted) {
        if (delivery.qos == Qos::exactly_once) {  // 6.6a: never the answer to QoS 2
            tables_.count(Drop::unexpected);
            return;
        }
        end_at_cell(session, 0, turn);
    } else if (message.return_code == ReturnCode::congestion) {
        open(session, Kind::publishing, exchange.msg_id, exchange.topic);
        if (session.header.state == SessionState::awake) {  // all else waits for its next awakening
            outbox_.send(session, mqttsn::Pingresp{}, Gate::open, turn);
            return fall_asleep(session, turn);
        }
        session.exchange.retry_at = turn.now + tables_.options.t_wait;
        schedule(tables_, session);
    } else if (exchange.refused) {
        drop_front(session, Drop::refused_by_client, turn);
        go_on(session, turn);
    } else if (message.return_code == ReturnCode::invalid_topic_id) {
        if (exchange.topic.type == TopicIdType::normal) {
            subscriptions_.set_known(session, exchange.topic.id, false, turn);
        }
        fall_back(session, delivery.qos, exchange.bare, turn);
    } else {
        fall_back(session, Qos::at_least_once, true, turn);
    }
}

/// Once more under a new msg id, without DUP: after REGISTER if the id is not known (G21), at QoS 1
/// at most and bare if the client does not support it otherwise (G25).
void DeliveryFlow::fall_back(Session& session, Qos most, bool bare, Turn& turn) {
    Delivery& delivery = session.queue.current();
    delivery.qos = std::min(delivery.qos, most);
    start(session, delivery, turn);
    session.exchange = {};
    session.exchange.refused = true;
    session.exchange.bare = bare;
    go_on(session, turn);
}

void DeliveryFlow::on_pubrec(Session& session, const mqttsn::Pubrec& message, Turn& turn) {
    Exchange& exchange = session.exchange;
    const bool ours = exchange.msg_id == message.msg_id;
    if (exchange.kind == Kind::publishing && ours &&
        session.queue.current().qos == Qos::exactly_once) {
        release_front(session, turn);
        open(session, Kind::releasing, message.msg_id, {});
        send_open(session, false, turn);
    } else if (exchange.kind == Kind::releasing && ours) {
        send_open(session, true, turn);
    } else if (is_left_at(session, DeliveryStage::published, message.msg_id)) {
        release_front(session, turn);
        outbox_.send(session, mqttsn::Pubrel{message.msg_id}, Gate::logged, turn);
    } else {
        // We gave this message up or finished it: the client may finish it too.
        tables_.count(Drop::unexpected);
        outbox_.send(session, mqttsn::Pubrel{message.msg_id}, Gate::logged, turn);
    }
}

/// The client went to sleep amid the exchange, and its answer came behind its DISCONNECT: it holds
/// the message, and forgets the id as soon as it is released.
bool DeliveryFlow::is_left_at(Session& session, DeliveryStage stage, MsgId msg_id) {
    if (session.exchange.is_open() || session.queue.empty()) return false;
    const Delivery& delivery = session.queue.current();
    return delivery.qos == Qos::exactly_once && delivery.stage == stage &&
           delivery.msg_id == msg_id;
}

void DeliveryFlow::release_front(Session& session, Turn& turn) {
    Delivery& delivery = session.queue.current();
    delivery.stage = DeliveryStage::released;
    tables_.log.append(turn.out, [&] {
        return DeliveryReleased{session.header.client_id, delivery.position};
    });
}

void DeliveryFlow::release_unfinished(Session& session, Turn& turn) {
    if (session.unfinished == mqttsn::no_msg_id || !session.is_listening()) return;
    outbox_.send(session, mqttsn::Pubrel{session.unfinished}, Gate::open, turn);
}

void DeliveryFlow::on_pubcomp(Session& session, const mqttsn::Pubcomp& message, Turn& turn) {
    const Exchange& exchange = session.exchange;
    const bool ours = exchange.kind == Kind::releasing && exchange.msg_id == message.msg_id;
    if (!ours && !is_left_at(session, DeliveryStage::released, message.msg_id)) {
        if (message.msg_id == session.unfinished) {
            session.unfinished = mqttsn::no_msg_id;
        } else {
            tables_.count(Drop::unexpected);
        }
        return;
    }
    end_front(session, turn);
    go_on(session, turn);
}

void DeliveryFlow::end_front(Session& session, Turn& turn) {
    const Delivery& delivery = session.queue.current();
    if (delivery.stage == DeliveryStage::queued) {  // never to be sent again
        const auto begun = std::ranges::find(session.begun, delivery.position, &Begun::position);
        if (begun != session.begun.end()) session.begun.erase(begun);
    }
    if (delivery.qos != Qos::at_most_once) {
        tables_.log.append(turn.out, [&] {
            return DeliveryEnded{session.header.client_id, delivery.position};
        });
    }
    session.queue.pop();
    session.exchange = {};
}

void DeliveryFlow::drop_front(Session& session, Drop reason, Turn& turn) {
    tables_.count(reason);
    end_front(session, turn);
}

void DeliveryFlow::resume(Session& session, Turn& turn) {
    Exchange& exchange = session.exchange;
    if (!session.is_listening() || (!exchange.stalled && exchange.asked == 0)) return;
    exchange.asked = 0;
    if (std::exchange(exchange.stalled, false)) exchange.sendings = 0;
    if (!send_open(session, true, turn)) go_on(session, turn);
}

bool DeliveryFlow::repeat(Session& session, Turn& turn) {
    if (!session.exchange.is_open()) return false;
    count_pass(session.exchange);
    return send_open(session, true, turn);
}

void DeliveryFlow::send_again(Session& session, Turn& turn) {
    const Exchange& exchange = session.exchange;
    if (!exchange.is_open()) return go_on(session, turn);
    if (exchange.stalled || !session.is_listening()) return;
    if (exchange.retry_at == turn.now + patience_with(session)) return;
    if (!send_open(session, true, turn)) go_on(session, turn);
}

void DeliveryFlow::on_retry(Session& session, Turn& turn) {
    Exchange& exchange = session.exchange;
    count_pass(exchange);
    if (!session.is_listening()) {
        exchange.stalled = true;  // another client has its address now (G7)
    } else if (names_known_id(session)) {
        publish_anyway(session, true, turn);
    } else if (exchange.sendings > tables_.options.n_retry ||
               (exchange.doubted && is_passed_over(session))) {
        give_up(session, turn);
    } else if (!send_open(session, true, turn)) {
        go_on(session, turn);
    }
}

void DeliveryFlow::ask(Session& session, Turn& turn) {
    Exchange& exchange = session.exchange;
    if (!session.is_listening() || exchange.asked >= tables_.options.n_retry) {
        exchange.stalled = true;
        return;
    }
    ++exchange.asked;
    if (session.header.state == SessionState::active) {  // one that sleeps is not asked
        outbox_.send(session, mqttsn::Pingreq{}, Gate::open, turn);
    }
    exchange.retry_at = turn.now + patience_with(session);
}

void DeliveryFlow::give_up(Session& session, Turn& turn) {
    const Exchange& exchange = session.exchange;
    const bool is_there =
        exchange.kind == Kind::registering ? exchange.heard : is_passed_over(session);
    if (!is_there && session.header.state == SessionState::awake) {  // its queue waits (G10)
        fall_asleep(session, turn);
    } else if (exchange.kind == Kind::registering) {  // such clients exist (G14)
        session.ignores_register = exchange.heard;
        publish_anyway(session, exchange.heard, turn);
    } else if (is_passed_over(session)) {
        tables_.notes.say(turn.now, turn.out, [&] {
            const Message& message = *session.queue.current().message;
            return "client '" + printable(session.header.client_id) +
                   "' answers, but not to a message of " + std::to_string(message.payload.size()) +
                   " octets on '" + printable(message.topic) + "': it is dropped for this client";
        });
        drop_front(session, Drop::retries_exhausted, turn);
        go_on(session, turn);
    } else {
        doubt(session, turn);
    }
}

/// The client is there, and cannot take the current message.
bool DeliveryFlow::is_passed_over(const Session& session) const {
    return session.exchange.ignored >= std::min(often_enough, tables_.options.n_retry + 1);
}

/// Silent: its queue waits for it (G5). Or is it there? One that may be asleep is not asked.
void DeliveryFlow::doubt(Session& session, Turn& turn) {
    session.exchange.stalled = session.exchange.doubted = true;
    if (!session.seems_connected()) outbox_.send(session, mqttsn::Pingreq{}, Gate::open, turn);
}

/// REGISTER was not answered: PUBLISH without it. `known`: do not ask for this id again.
void DeliveryFlow::publish_anyway(Session& session, bool known, Turn& turn) {
    const WireTopic topic = session.exchange.topic;
    if (known) subscriptions_.set_known(session, topic.id, true, turn);
    session.exchange.kind = Kind::none;
    if (!publish_front(session, topic, turn)) go_on(session, turn);
}

void DeliveryFlow::fall_asleep(Session& session, Turn& turn) {
    session.exchange = {.ignored = session.exchange.ignored, .topic = {}};
    session.heard_at = turn.now;  // restarts the sleep timer
    session.header.state = SessionState::asleep;
    tables_.log.append(turn.out, [&] { return SessionChanged{session.header}; });
    schedule(tables_, session);
}

MsgId DeliveryFlow::msg_id_for(Session& session, const Delivery& delivery) {
    const auto begun = std::ranges::find(session.begun, delivery.position, &Begun::position);
    if (begun == session.begun.end()) return next_msg_id(session);
    const MsgId msg_id = begun->msg_id;
    session.begun.erase(begun);
    return msg_id;
}

MsgId DeliveryFlow::next_msg_id(Session& session) {
    if (++session.last_msg_id == 0) session.last_msg_id = 1;
    return MsgId{session.last_msg_id};
}

}  // namespace romano::broker
