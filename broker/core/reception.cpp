#include "broker/core/reception.h"

#include <algorithm>
#include <variant>

namespace romano::broker {

using mqttsn::MsgType;

namespace {

/// Messages that only brokers send.
bool is_from_a_broker(MsgType type) {
    switch (type) {
        case MsgType::connack:
        case MsgType::willtopicreq:
        case MsgType::willmsgreq:
        case MsgType::suback:
        case MsgType::unsuback:
        case MsgType::willtopicresp:
        case MsgType::willmsgresp:
            return true;
        default:
            return false;
    }
}

/// Requests, which a stranger is told about; answers to nothing are not (G8).
bool is_request(MsgType type) {
    switch (type) {
        case MsgType::publish:
        case MsgType::pubrel:
        case MsgType::subscribe:
        case MsgType::unsubscribe:
        case MsgType::register_:
        case MsgType::pingreq:
        case MsgType::willtopicupd:
        case MsgType::willmsgupd:
        case MsgType::disconnect:
            return true;
        default:
            return false;
    }
}

bool is_connectionless(const mqttsn::Message& message) {
    const auto* publish = std::get_if<mqttsn::Publish>(&message);
    return publish != nullptr && publish->qos == mqttsn::Qos::without_connection;
}

}  // namespace

void Reception::on_datagram(const Origin& origin, Bytes datagram, bool wrapped, Turn& turn) {
    if (tables_.full && !wrapped) lifecycle_.make_room(turn);
    const auto decoded = mqttsn::decode(datagram);
    if (!decoded) {
        ++tables_.counters.malformed[static_cast<std::size_t>(decoded.error())];
        ++tables_.counters.malformed_total;
        return;
    }
    const mqttsn::Message& message = *decoded;
    const MsgType type = mqttsn::type_of(message);
    ++tables_.counters.received_by_type[static_cast<std::size_t>(type)];

    switch (type) {
        case MsgType::encapsulated:
            if (wrapped) {
                tables_.count(Drop::encapsulation);
            } else {
                on_encapsulated(origin, std::get<mqttsn::Encapsulated>(message), turn);
            }
            return;
        case MsgType::advertise:  // other gateways of the network, and clients that tell of them
        case MsgType::gwinfo:
            return;
        case MsgType::searchgw:
            if (strangers_.allows(origin.from.endpoint, turn.now)) {
                discovery_.on_searchgw(origin.via, origin.from, std::get<mqttsn::Searchgw>(message),
                                       turn);
            } else {
                tables_.count(Drop::stranger_rate);
            }
            return;
        case MsgType::connect:
            if (!is_heeded(origin, turn)) return;
            connect_flow_.on_connect(origin, std::get<mqttsn::Connect>(message), turn);
            return;
        case MsgType::willtopic:
            if (!is_heeded(origin, turn)) return;
            connect_flow_.on_willtopic(origin, std::get<mqttsn::Willtopic>(message), turn);
            return;
        case MsgType::willmsg:
            if (!is_heeded(origin, turn)) return;
            connect_flow_.on_willmsg(origin, std::get<mqttsn::Willmsg>(message), turn);
            return;
        default:
            break;
    }
    if (is_from_a_broker(type)) {
        tables_.count(Drop::wrong_direction);
        return;
    }
    on_session_message(origin, message, turn);
}

void Reception::on_encapsulated(const Origin& origin, const mqttsn::Encapsulated& frame,
                                Turn& turn) {
    if (frame.wireless_node_id.empty() || frame.message.empty()) {
        tables_.count(Drop::encapsulation);
        return;
    }
    Origin inner = origin;
    inner.from.wireless_node_id = as_text(frame.wireless_node_id);
    on_datagram(inner, frame.message, true, turn);
}

Session* Reception::session_at(const Origin& origin) const {
    if (Session* heard = tables_.sessions.find(origin)) {
        return heard->is_connected() ? heard : nullptr;
    }
    Session* roaming = tables_.sessions.only_one_at(origin.from);
    const bool is_it = roaming != nullptr && (tables_.peers == nullptr ||
                                              !tables_.peers->share_address_with(roaming->header));
    return is_it ? roaming : nullptr;
}

Session* Reception::session_of(const Origin& origin, const mqttsn::Message& message) const {
    Session* session = session_at(origin);
    // Whoever publishes without a connection may talk to any gateway beside its own (6.8).
    if (session != nullptr && is_connectionless(message) && !session->is_at(origin)) return nullptr;
    const auto* ping = std::get_if<mqttsn::Pingreq>(&message);
    if (ping == nullptr || ping->client_id.empty()) return session;
    Session* named = tables_.sessions.find(ping->client_id);
    if (named == session) return session;
    // A sleeping client that woke up somewhere else (6.14e, G9). Nobody else may be named so.
    const bool sleeps = named != nullptr && (named->header.state == SessionState::asleep ||
                                             named->header.state == SessionState::awake);
    return sleeps ? named : nullptr;
}

void Reception::on_session_message(const Origin& origin, const mqttsn::Message& message,
                                   Turn& turn) {
    Session* session = session_of(origin, message);
    const bool connectionless = is_connectionless(message);
    if (session == nullptr && !connectionless) {
        on_stranger(origin, mqttsn::type_of(message), turn);
        return;
    }
    if (session == nullptr && !strangers_.allows(origin.from.endpoint, turn.now)) {
        tables_.count(Drop::stranger_rate);
        return;
    }
    if (session != nullptr) {
        session->fresh = session->fresh_will = false;
        liveness_.on_heard(*session, origin, mqttsn::type_of(message), turn);
    }
    if (connectionless) {
        ++tables_.counters.publishes_received;
        publish_flow_.on_connectionless(origin, std::get<mqttsn::Publish>(message), turn);
    } else {
        handle(*session, message, turn);
    }
    if (session == nullptr) return;
    // An answer may have made room. (A PUBLISH has not, and must not touch more of the session's
    // memory than it needs.)
    if (mqttsn::type_of(message) != MsgType::publish && !session->retained_to_come.empty()) {
        router_.send_more_retained(*session, turn);
    }
    deliveries_.resume(*session, turn);
}

void Reception::handle(Session& session, const mqttsn::Message& message, Turn& turn) {
    switch (mqttsn::type_of(message)) {
        case MsgType::publish:
            ++tables_.counters.publishes_received;
            publish_flow_.on_publish(session, std::get<mqttsn::Publish>(message), turn);
            break;
        case MsgType::pubrel:
            publish_flow_.on_pubrel(session, std::get<mqttsn::Pubrel>(message), turn);
            break;
        case MsgType::puback:
            deliveries_.on_puback(session, std::get<mqttsn::Puback>(message), turn);
            break;
        case MsgType::pubrec:
            deliveries_.on_pubrec(session, std::get<mqttsn::Pubrec>(message), turn);
            break;
        case MsgType::pubcomp:
            deliveries_.on_pubcomp(session, std::get<mqttsn::Pubcomp>(message), turn);
            break;
        case MsgType::register_:
            subscribe_flow_.on_register(session, std::get<mqttsn::Register>(message), turn);
            break;
        case MsgType::regack:
            deliveries_.on_regack(session, std::get<mqttsn::Regack>(message), turn);
            break;
        case MsgType::subscribe:
            subscribe_flow_.on_subscribe(session, std::get<mqttsn::Subscribe>(message), turn);
            break;
        case MsgType::unsubscribe:
            subscribe_flow_.on_unsubscribe(session, std::get<mqttsn::Unsubscribe>(message), turn);
            break;
        case MsgType::pingreq:
            liveness_.on_pingreq(session, std::get<mqttsn::Pingreq>(message), turn);
            break;
        case MsgType::disconnect:
            liveness_.on_disconnect(session, std::get<mqttsn::Disconnect>(message), turn);
            break;
        case MsgType::willtopicupd:
            connect_flow_.on_willtopicupd(session, std::get<mqttsn::Willtopicupd>(message), turn);
            break;
        case MsgType::willmsgupd:
            connect_flow_.on_willmsgupd(session, std::get<mqttsn::Willmsgupd>(message), turn);
            break;
        default:  // PINGRESP: that it came was all
            break;
    }
}

bool Reception::is_heeded(const Origin& origin, Turn& turn) {
    if (session_at(origin) != nullptr || strangers_.allows(origin.from.endpoint, turn.now)) {
        return true;
    }
    tables_.count(Drop::stranger_rate);
    return false;
}

void Reception::on_stranger(const Origin& origin, MsgType type, Turn& turn) {
    if (!is_request(type)) {
        tables_.count(Drop::unknown_sender);
    } else if (!strangers_.allows(origin.from.endpoint, turn.now) ||
               !(has_key(origin) || disconnects_.allows(turn.now))) {
        tables_.count(Drop::stranger_rate);
    } else {
        tables_.count(Drop::unknown_sender);
        outbox_.answer(origin.via, origin.from, mqttsn::Disconnect{}, turn);
    }
}

void Reception::on_tick(const SessionJudgement& may_be_unheard, Turn& turn) {
    liveness_.on_tick(may_be_unheard, turn);
    connect_flow_.on_tick(turn.now);
    discovery_.on_tick(turn);
}

Instant Reception::next_wakeup() const {
    return std::min(
        {tables_.deadlines.next(), connect_flow_.next_wakeup(), discovery_.next_wakeup()});
}

}  // namespace romano::broker
