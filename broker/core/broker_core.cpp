#include "broker/core/broker_core.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "broker/core/adoption.h"
#include "broker/core/connect_flow.h"
#include "broker/core/delivery_flow.h"
#include "broker/core/enforcement.h"
#include "broker/core/invariants.h"
#include "broker/core/lifecycle.h"
#include "broker/core/outbox.h"
#include "broker/core/reception.h"
#include "broker/core/router.h"
#include "broker/core/session_image_of.h"
#include "broker/core/subscriptions.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/codec.h"

namespace romano::broker {
namespace {

/// Looks at `most` numbers, from that one on, and returns the next one; none when it was the last.
template <typename Look>
std::optional<std::uint32_t> visit_some(const SessionTable& sessions, std::uint32_t from,
                                        std::size_t most, Look&& look) {
    const std::size_t end = std::min(sessions.numbers(), from + most);
    for (; from < end; ++from) {
        if (Session* session = sessions.at(from)) look(*session);
    }
    return from < sessions.numbers() ? std::optional{from} : std::nullopt;
}

struct Sender {
    Origin place;
    std::optional<ClientId> client_id;  // if the datagram names it
};

/// None when it is no message.
std::optional<Sender> sender_of(Origin place, Bytes datagram) {
    auto decoded = mqttsn::decode(datagram);
    if (!decoded) return std::nullopt;
    if (const auto* frame = std::get_if<mqttsn::Encapsulated>(&*decoded)) {
        place.from.wireless_node_id = as_text(frame->wireless_node_id);
        decoded = mqttsn::decode(frame->message);
        if (!decoded) return std::nullopt;
    }
    std::optional<ClientId> named;
    if (const auto* connect = std::get_if<mqttsn::Connect>(&*decoded)) {
        named = ConnectFlow::client_id_of(place, *connect);
    } else if (const auto* ping = std::get_if<mqttsn::Pingreq>(&*decoded)) {
        if (!ping->client_id.empty()) named = ping->client_id;
    }
    return Sender{std::move(place), std::move(named)};
}

}  // namespace

/// The procedures, composed.
class BrokerCore::State {
public:
    State(const BrokerOptions& options, std::uint64_t seed) : tables(options, seed) {}

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
    Reception reception{tables, outbox, enforcement, subscriptions, deliveries, router, lifecycle};

private:
    Instant forget_deletions_at_{};
};

void BrokerCore::State::on_tick(const SessionJudgement& may_be_unheard, Turn& turn) {
    reception.on_tick(may_be_unheard, turn);
    if (turn.now < forget_deletions_at_) return;
    const Duration kept = tables.options.deletions_kept_for;
    tables.retained.forget_deletions(tables.clock.reading(turn.now - kept));
    forget_deletions_at_ = turn.now + kept / 4;
}

Instant BrokerCore::State::next_wakeup() const {
    const Instant deletions = tables.retained.has_deletions() ? forget_deletions_at_ : never;
    return std::min(reception.next_wakeup(), deletions);
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
    state_->reception.on_datagram({via, {from, {}}}, datagram, false, turn);
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

void BrokerCore::set_silence(std::function<bool(const SessionHeader&, Instant)> is_silent) {
    state_->tables.is_silent = std::move(is_silent);
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

void BrokerCore::pass_on(const SessionImage& image, const LogId& to,
                         const std::optional<LogPosition>& moved, Actions& out) {
    LogWriter& log = state_->tables.log;
    log.append(out, [&] { return SessionPut{image, moved}; });
    log.append(out, [&] { return SessionMoved{image.header, to}; });
}

void BrokerCore::append_header(std::string_view client_id, Actions& out) {
    const SessionHeader* now = header(client_id);
    if (now != nullptr) state_->tables.log.append(out, [&] { return SessionChanged{*now}; });
}

void BrokerCore::seal(const Endpoint& address, const LogId& to, Actions& out) {
    state_->tables.log.append(out, [&] { return Sealed{address, to}; });
}

std::optional<std::uint32_t> BrokerCore::send_again(Instant now, const Endpoint& via,
                                                    std::uint32_t from, std::size_t most,
                                                    Actions& out) {
    Turn turn{now, out};
    return visit_some(state_->tables.sessions, from, most, [&](Session& session) {
        if (session.header.via == via) state_->deliveries.send_again(session, turn);
    });
}

std::optional<std::uint32_t> BrokerCore::begin_waiting(Instant now, std::uint32_t from,
                                                       std::size_t most, Actions& out) {
    Turn turn{now, out};
    return visit_some(state_->tables.sessions, from, most, [&](Session& session) {
        if (!session.queue.empty()) state_->deliveries.go_on(session, turn);
    });
}

bool BrokerCore::serves(const Endpoint& via, const Endpoint& from, Bytes datagram) const {
    const auto sender = sender_of({via, {from, {}}}, datagram);
    if (!sender) return false;
    if (sender->client_id) return header(*sender->client_id) != nullptr;
    return state_->reception.knows(sender->place);
}

bool BrokerCore::has_session_at(const Endpoint& via, const Endpoint& from, Bytes datagram) const {
    const auto sender = sender_of({via, {from, {}}}, datagram);
    if (!sender) return false;
    if (sender->client_id) return header(*sender->client_id) != nullptr;
    return state_->tables.sessions.find(sender->place) != nullptr;
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

std::optional<std::uint32_t> BrokerCore::visit_client_ids(
    std::uint32_t from, std::size_t most, const std::function<void(const ClientId&)>& look) const {
    return visit_some(state_->tables.sessions, from, most,
                      [&](const Session& session) { look(session.header.client_id); });
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
