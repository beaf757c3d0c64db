#include "broker/core/broker_core.h"

#include <algorithm>
#include <cassert>
#include <utility>
#include <variant>

#include "broker/core/adoption.h"
#include "broker/core/connect_flow.h"
#include "broker/core/delivery_flow.h"
#include "broker/core/discovery.h"
#include "broker/core/enforcement.h"
#include "broker/core/invariants.h"
#include "broker/core/lifecycle.h"
#include "broker/core/liveness.h"
#include "broker/core/outbox.h"
#include "broker/core/publish_flow.h"
#include "broker/core/router.h"
#include "broker/core/session_image_of.h"
#include "broker/core/stranger_answers.h"
#include "broker/core/stranger_limit.h"
#include "broker/core/subscribe_flow.h"
#include "broker/core/subscriptions.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/codec.h"

namespace romano::broker {

using mqttsn::MsgType;

/// The procedures, composed; and the way of a datagram to the one that it belongs to.
class BrokerCore::State {
public:
    State(const BrokerOptions& options, std::uint64_t seed)
        : tables(options, seed),
          strangers_(options.limits.stranger_datagrams_per_second,
                     options.limits.address_stranger_datagrams_per_second),
          disconnects_(options.limits.stranger_answers_per_second) {}

    void on_datagram(const Origin& origin, Bytes datagram, bool wrapped, Turn& turn);
    void on_tick(const SessionJudgement& may_be_unheard, Turn& turn);
    [[nodiscard]] Instant next_wakeup() const;

    Tables tables;
    Outbox outbox{tables};
    Enforcement enforcement{tables};
    Subscriptions subscriptions{tables};
    DeliveryFlow deliveries{tables, outbox, subscriptions, enforcement};
    Router router{tables, outbox, deliveries, enforcement};
    Lifecycle lifecycle{tables, router, subscriptions, enforcement};
    Adoption adoption{tables, deliveries, lifecycle, subscriptions};

    /// Of the connected client that speaks there, or null. One that was heard at another service
    /// address has come here if nobody else is connected from its address.
    [[nodiscard]] Session* session_at(const Origin& origin) const;
    /// What comes from there is not another broker's to answer.
    [[nodiscard]] bool knows(const Origin& origin) const {
        return tables.sessions.find(origin) != nullptr || connect_flow_.is_asking(origin) ||
               session_at(origin) != nullptr;
    }

private:
    void on_encapsulated(const Origin& origin, const mqttsn::Encapsulated& frame, Turn& turn);
    void on_session_message(const Origin& origin, const mqttsn::Message& message, Turn& turn);
    /// The session that a datagram belongs to, or null.
    Session* session_of(const Origin& origin, const mqttsn::Message& message) const;
    void handle(Session& session, const mqttsn::Message& message, Turn& turn);
    void on_stranger(const Origin& origin, MsgType type, Turn& turn);
    /// Who is connected is; others up to a rate.
    [[nodiscard]] bool is_heeded(const Origin& origin, Turn& turn);

    PublishFlow publish_flow_{tables, outbox, router, enforcement};
    SubscribeFlow subscribe_flow_{tables, outbox, router, subscriptions, enforcement};
    ConnectFlow connect_flow_{tables, outbox, deliveries, lifecycle, subscriptions, enforcement};
    Liveness liveness_{tables, outbox, deliveries, lifecycle, publish_flow_};
    Discovery discovery_{tables, outbox};
    StrangerLimit strangers_;
    StrangerAnswers disconnects_;
    Instant forget_deletions_at_{};
};

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

void BrokerCore::State::on_datagram(const Origin& origin, Bytes datagram, bool wrapped,
                                    Turn& turn) {
    if (tables.full && !wrapped) lifecycle.make_room(turn);
    const auto decoded = mqttsn::decode(datagram);
    if (!decoded) {
        ++tables.counters.malformed[static_cast<std::size_t>(decoded.error())];
        ++tables.counters.malformed_total;
        return;
    }
    const mqttsn::Message& message = *decoded;
    const MsgType type = mqttsn::type_of(message);
    ++tables.counters.received_by_type[static_cast<std::size_t>(type)];

    switch (type) {
        case MsgType::encapsulated:
            if (wrapped) {
                tables.count(Drop::encapsulation);
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
                tables.count(Drop::stranger_rate);
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
        tables.count(Drop::wrong_direction);
        return;
    }
    on_session_message(origin, message, turn);
}

void BrokerCore::State::on_encapsulated(const Origin& origin, const mqttsn::Encapsulated& frame,
                                        Turn& turn) {
    if (frame.wireless_node_id.empty() || frame.message.empty()) {
        tables.count(Drop::encapsulation);
        return;
    }
    Origin inner = origin;
    inner.from.wireless_node_id = as_text(frame.wireless_node_id);
    on_datagram(inner, frame.message, true, turn);
}

Session* BrokerCore::State::session_at(const Origin& origin) const {
    if (Session* heard = tables.sessions.find(origin)) {
        return heard->is_connected() ? heard : nullptr;
    }
    Session* roaming = tables.sessions.only_one_at(origin.from);
    const bool is_it = roaming != nullptr && (tables.peers == nullptr ||
                                              !tables.peers->share_address_with(roaming->header));
    return is_it ? roaming : nullptr;
}

Session* BrokerCore::State::session_of(const Origin& origin, const mqttsn::Message& message) const {
    Session* session = session_at(origin);
    // Whoever publishes without a connection may talk to any gateway beside its own (6.8).
    if (session != nullptr && is_connectionless(message) && !session->is_at(origin)) return nullptr;
    const auto* ping = std::get_if<mqttsn::Pingreq>(&message);
    if (ping == nullptr || ping->client_id.empty()) return session;
    Session* named = tables.sessions.find(ping->client_id);
    if (named == session) return session;
    // A sleeping client that woke up somewhere else (6.14e, G9). Nobody else may be named so.
    const bool sleeps = named != nullptr && (named->header.state == SessionState::asleep ||
                                             named->header.state == SessionState::awake);
    return sleeps ? named : nullptr;
}

void BrokerCore::State::on_session_message(const Origin& origin, const mqttsn::Message& message,
                                           Turn& turn) {
    Session* session = session_of(origin, message);
    const bool connectionless = is_connectionless(message);
    if (session == nullptr && !connectionless) {
        on_stranger(origin, mqttsn::type_of(message), turn);
        return;
    }
    if (session == nullptr && !strangers_.allows(origin.from.endpoint, turn.now)) {
        tables.count(Drop::stranger_rate);
        return;
    }
    if (session != nullptr) {
        session->fresh = session->fresh_will = false;
        liveness_.on_heard(*session, origin, mqttsn::type_of(message), turn);
    }
    if (connectionless) {
        ++tables.counters.publishes_received;
        publish_flow_.on_connectionless(origin, std::get<mqttsn::Publish>(message), turn);
    } else {
        handle(*session, message, turn);
    }
    if (session == nullptr) return;
    // An answer may have made room. (A PUBLISH has not, and must not touch more of the session's
    // memory than it needs.)
    if (mqttsn::type_of(message) != MsgType::publish && !session->retained_to_come.empty()) {
        router.send_more_retained(*session, turn);
    }
    deliveries.resume(*session, turn);
}

void BrokerCore::State::handle(Session& session, const mqttsn::Message& message, Turn& turn) {
    switch (mqttsn::type_of(message)) {
        case MsgType::publish:
            ++tables.counters.publishes_received;
            publish_flow_.on_publish(session, std::get<mqttsn::Publish>(message), turn);
            break;
        case MsgType::pubrel:
            publish_flow_.on_pubrel(session, std::get<mqttsn::Pubrel>(message), turn);
            break;
        case MsgType::puback:
            deliveries.on_puback(session, std::get<mqttsn::Puback>(message), turn);
            break;
        case MsgType::pubrec:
            deliveries.on_pubrec(session, std::get<mqttsn::Pubrec>(message), turn);
            break;
        case MsgType::pubcomp:
            deliveries.on_pubcomp(session, std::get<mqttsn::Pubcomp>(message), turn);
            break;
        case MsgType::register_:
            subscribe_flow_.on_register(session, std::get<mqttsn::Register>(message), turn);
            break;
        case MsgType::regack:
            deliveries.on_regack(session, std::get<mqttsn::Regack>(message), turn);
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

bool BrokerCore::State::is_heeded(const Origin& origin, Turn& turn) {
    if (session_at(origin) != nullptr || strangers_.allows(origin.from.endpoint, turn.now)) {
        return true;
    }
    tables.count(Drop::stranger_rate);
    return false;
}

void BrokerCore::State::on_stranger(const Origin& origin, MsgType type, Turn& turn) {
    if (!is_request(type)) {
        tables.count(Drop::unknown_sender);
    } else if (!strangers_.allows(origin.from.endpoint, turn.now) ||
               !(has_key(origin) || disconnects_.allows(turn.now))) {
        tables.count(Drop::stranger_rate);
    } else {
        tables.count(Drop::unknown_sender);
        outbox.answer(origin.via, origin.from, mqttsn::Disconnect{}, turn);
    }
}

void BrokerCore::State::on_tick(const SessionJudgement& may_be_unheard, Turn& turn) {
    liveness_.on_tick(may_be_unheard, turn);
    connect_flow_.on_tick(turn.now);
    discovery_.on_tick(turn);
    if (turn.now < forget_deletions_at_) return;
    const Duration kept = tables.options.deletions_kept_for;
    tables.retained.forget_deletions(tables.clock.reading(turn.now - kept));
    forget_deletions_at_ = turn.now + kept / 4;
}

Instant BrokerCore::State::next_wakeup() const {
    const Instant deletions = tables.retained.has_deletions() ? forget_deletions_at_ : never;
    return std::min({tables.deadlines.next(), connect_flow_.next_wakeup(), discovery_.next_wakeup(),
                     deletions});
}

// --- BrokerCore

BrokerCore::BrokerCore(const BrokerOptions& options, std::uint64_t seed)
    : state_(std::make_unique<State>(options, seed)) {}
BrokerCore::~BrokerCore() = default;
BrokerCore::BrokerCore(BrokerCore&&) noexcept = default;
BrokerCore& BrokerCore::operator=(BrokerCore&&) noexcept = default;

void BrokerCore::on_datagram(Instant now, const Endpoint& via, const Endpoint& from, Bytes datagram,
                             Actions& out) {
    Turn turn{now, out};
    state_->on_datagram({via, {from, {}}}, datagram, false, turn);
}

void BrokerCore::on_tick(Instant now, Actions& out, const SessionJudgement& may_be_unheard) {
    Turn turn{now, out};
    state_->on_tick(may_be_unheard, turn);
}

Instant BrokerCore::next_wakeup() const {
    return state_->next_wakeup();
}

void BrokerCore::on_peer_message(Instant now, const MessagePtr& message, Actions& out) {
    Turn turn{now, out};
    state_->router.on_peer_message(message, turn);
}

Seq BrokerCore::cursor(const LogId& log) const {
    return state_->tables.cursors.at(log);
}

std::vector<LogPosition> BrokerCore::cursors() const {
    return state_->tables.cursors.all();
}

void BrokerCore::append_cursors(Actions& out) {
    Tables& tables = state_->tables;
    const std::vector<LogPosition> moved = tables.cursors.unlogged();
    if (moved.empty()) return;
    tables.log.append(out, [&] { return Cursor{moved}; });
    for (const LogPosition& position : moved) tables.cursors.logged(position);
}

void BrokerCore::advance_cursor(const LogPosition& through) {
    state_->tables.cursors.advance(through);
}

void BrokerCore::set_audience(const Audience& peers) {
    state_->tables.peers = &peers;
}

void BrokerCore::set_permissions(const Permissions* permissions) {
    state_->tables.permissions = permissions;
    state_->tables.sessions.visit(
        [this](const Session& session) { state_->subscriptions.enter_all(session); });
}

void BrokerCore::forget_logs(const std::function<bool(const LogId&)>& are_over, Actions& out) {
    state_->tables.cursors.forget(are_over);
    state_->adoption.forget_logs(are_over, out);
}

bool BrokerCore::adopt(Instant now, SessionImage image, std::vector<MessagePtr> missed,
                       Actions& out, const std::optional<LogPosition>& moved,
                       std::optional<SessionImage> ours) {
    // The image that goes into the log is worked through up to here, and its mirrors must know.
    append_cursors(out);
    Turn turn{now, out};
    return state_->adoption.adopt(std::move(image), std::move(missed), moved, std::move(ours),
                                  turn);
}

SessionImage BrokerCore::caught_up(SessionImage image, std::span<const MessagePtr> missed) {
    return state_->adoption.caught_up(std::move(image), missed);
}

std::optional<SessionImage> BrokerCore::release(std::string_view client_id, Actions& out) {
    return state_->adoption.release(client_id, out);
}

std::optional<SessionImage> BrokerCore::move_away(std::string_view client_id, const LogId& to,
                                                  std::uint64_t epochs, Actions& out) {
    append_cursors(out);  // the new home reads there what was worked through
    return state_->adoption.move_away(client_id, to, epochs, out);
}

void BrokerCore::pass_on(const SessionImage& image, const LogId& to, Actions& out) {
    LogWriter& log = state_->tables.log;
    log.append(out, [&] { return SessionPut{image}; });
    log.append(out, [&] { return SessionMoved{image.header, to}; });
}

void BrokerCore::seal(const Endpoint& address, const LogId& to, Actions& out) {
    state_->tables.log.append(out, [&] { return Sealed{address, to}; });
}

std::optional<std::uint32_t> BrokerCore::send_again(Instant now, const Endpoint& via,
                                                    std::uint32_t from, std::size_t most,
                                                    Actions& out) {
    Turn turn{now, out};
    const SessionTable& sessions = state_->tables.sessions;
    const std::size_t end = std::min(sessions.numbers(), from + most);
    for (; from < end; ++from) {
        Session* session = sessions.at(from);
        if (session == nullptr || session->header.via != via) continue;
        state_->deliveries.send_again(*session, turn);
    }
    return from < sessions.numbers() ? std::optional{from} : std::nullopt;
}

bool BrokerCore::serves(const Endpoint& via, const Endpoint& from, Bytes datagram) const {
    auto decoded = mqttsn::decode(datagram);
    if (!decoded) return false;
    Origin origin{via, {from, {}}};
    if (const auto* frame = std::get_if<mqttsn::Encapsulated>(&*decoded)) {
        origin.from.wireless_node_id = as_text(frame->wireless_node_id);
        decoded = mqttsn::decode(frame->message);
        if (!decoded) return false;
    }
    const SessionTable& sessions = state_->tables.sessions;
    if (const auto* connect = std::get_if<mqttsn::Connect>(&*decoded)) {
        return sessions.find(ConnectFlow::client_id_of(origin, *connect)) != nullptr;
    }
    const auto* ping = std::get_if<mqttsn::Pingreq>(&*decoded);
    if (ping != nullptr && !ping->client_id.empty()) {
        return sessions.find(ping->client_id) != nullptr;
    }
    return state_->knows(origin);
}

bool BrokerCore::has_client_at(const ClientAddress& address) const {
    return state_->tables.sessions.has_connected_at(address);
}

std::optional<SessionImage> BrokerCore::image(std::string_view client_id) const {
    const Session* session = state_->tables.sessions.find(client_id);
    if (session == nullptr) return std::nullopt;
    return image_of(*session, state_->tables);
}

const SessionHeader* BrokerCore::header(std::string_view client_id) const {
    const Session* session = state_->tables.sessions.find(client_id);
    return session == nullptr ? nullptr : &session->header;
}

std::vector<ClientId> BrokerCore::client_ids() const {
    std::vector<ClientId> all;
    all.reserve(session_count());
    state_->tables.sessions.visit(
        [&all](const Session& session) { all.push_back(session.header.client_id); });
    return all;
}

std::vector<SessionImage> BrokerCore::images() const {
    std::vector<SessionImage> all;
    for (const Session* session : state_->tables.sessions.by_client_id()) {
        all.push_back(image_of(*session, state_->tables));
    }
    return all;
}

std::vector<ClientId> BrokerCore::client_ids_via(const Endpoint& via) const {
    std::vector<ClientId> found;
    state_->tables.sessions.visit([&](const Session& session) {
        if (session.header.via == via) found.push_back(session.header.client_id);
    });
    return found;
}

bool BrokerCore::is_home_of_any_via(const Endpoint& via) const {
    bool is_home = false;
    state_->tables.sessions.visit(
        [&](const Session& session) { is_home |= session.header.via == via; });
    return is_home;
}

void BrokerCore::set_system_topic(Instant now, std::string_view topic, Bytes payload,
                                  Actions& out) {
    Turn turn{now, out};
    state_->router.set_system_topic(topic, payload, turn);
}

void BrokerCore::publish(Instant now, std::string_view topic, Bytes payload, mqttsn::Qos qos,
                         bool retain, Actions& out, std::string_view origin) {
    Turn turn{now, out};
    const Speaker owner{.via = {}, .node_id = {}, .client_id = {}, .is_owner = true};
    if (!origin.empty() && !state_->enforcement.may_publish(owner, topic, payload, turn)) return;
    state_->router.publish({topic, payload, qos, retain, origin}, turn);
}

std::span<const Delivery> BrokerCore::unread() const {
    const Tables& tables = state_->tables;
    const Session* session = tables.sessions.find(tables.options.read_by_owner);
    if (session == nullptr) return {};
    return {session->queue.begin(), session->queue.end()};
}

void BrokerCore::on_read(Instant now, const LogPosition& position, Actions& out) {
    Tables& tables = state_->tables;
    Session* session = tables.sessions.find(tables.options.read_by_owner);
    if (session == nullptr) return;
    Turn turn{now, out};
    state_->deliveries.on_read(*session, position, turn);
    state_->router.send_more_retained(*session, turn);
}

std::vector<MessagePtr> BrokerCore::retained(std::string_view filter) const {
    std::vector<MessagePtr> found;
    state_->tables.retained.match(filter, [&](const MessagePtr& message) {
        found.push_back(message);
        return true;
    });
    return found;
}

void BrokerCore::hold(Instant now, std::string_view client_id, bool held, Actions& out) {
    Session* session = state_->tables.sessions.find(client_id);
    if (session == nullptr || session->held == held) return;
    session->held = held;
    Turn turn{now, out};
    state_->deliveries.go_on(*session, turn);
}

void BrokerCore::set_congested(bool congested) {
    state_->tables.congested = congested;
}

void BrokerCore::set_full(bool full) {
    state_->tables.full = full;
}

void BrokerCore::on_output_dropped(Seq safe) {
    state_->tables.sessions.visit(
        [safe](Session& session) { session.output_floor = std::min(session.output_floor, safe); });
}

std::vector<MessagePtr> BrokerCore::retained() const {
    return state_->tables.retained.all();
}

void BrokerCore::put_retained(const MessagePtr& message) {
    state_->tables.clock.observe(message->published_at);
    state_->router.retain(message);
}

MessagePtr BrokerCore::retained_at(const LogPosition& position) const {
    return state_->tables.retained.find(position);
}

Seq BrokerCore::last_seq() const {
    return state_->tables.log.last();
}

void BrokerCore::observe_time(HybridTime time) {
    state_->tables.clock.observe(time);
}

const Limits& BrokerCore::limits() const {
    return state_->tables.limits();
}

const Counters& BrokerCore::counters() const {
    return state_->tables.counters;
}

Census BrokerCore::census() const {
    Census out;
    out.retained = state_->tables.retained.size();
    state_->tables.sessions.visit([&out](const Session& session) {
        ++out.sessions[static_cast<std::size_t>(session.header.state)];
        out.subscriptions += session.subscriptions.size();
        out.topics += session.topics.size();
        out.queued += session.queue.size();
        out.longest_queue = std::max(out.longest_queue, session.queue.size());
        out.in_flight += session.exchange.is_open() ? 1U : 0U;
        out.unreleased += session.unreleased.size();
    });
    return out;
}

std::size_t BrokerCore::session_count() const {
    return state_->tables.sessions.size();
}

std::size_t BrokerCore::connected_count() const {
    return state_->tables.sessions.connected();
}

void BrokerCore::check_invariants() const {
    broker::check_invariants(state_->tables);
}

}  // namespace romano::broker
