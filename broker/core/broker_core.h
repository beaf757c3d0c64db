// One MQTT-SN 1.2 broker without sockets, clocks or threads: datagrams and times in, actions out.
//
// It is the home of its sessions and the one writer of its log. Alone it appends nothing
// (BrokerOptions::writes_log); in a cluster the member that owns it carries its events to the peers
// and its peers' publishes back. Early or repeated ticks are harmless. Nothing here knows of the
// cluster.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "broker/core/actions.h"
#include "broker/core/audience.h"
#include "broker/core/counters.h"
#include "broker/core/limits.h"
#include "broker/core/log_event.h"
#include "broker/core/permissions.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"

namespace romano::broker {

class BrokerCore {
public:
    BrokerCore(const BrokerOptions& options, std::uint64_t seed);
    ~BrokerCore();
    BrokerCore(BrokerCore&&) noexcept;
    BrokerCore& operator=(BrokerCore&&) noexcept;

    /// A datagram from `from` that was sent to our service address `via`. Answers leave from `via`.
    void on_datagram(Instant now, const Endpoint& via, const Endpoint& from, Bytes datagram,
                     Actions& out);
    /// `may_be_unheard(client)`: what it says may wait somewhere, or be another broker's to hear.
    /// It is not lost for being silent then: its keep-alive begins anew. Nor is it sent again what
    /// it may have answered: it is asked for a sign of life.
    void on_tick(Instant now, Actions& out, const SessionJudgement& may_be_unheard = {});
    [[nodiscard]] Instant next_wakeup() const;

    /// Who may do what from now on: of subscriptions that are there already, too, and of what waits
    /// in queues. Null: everybody everything. It must outlive this broker, or the next one given.
    void set_permissions(const Permissions* permissions);

    // --- a cluster's side
    // -------------------------------------------------------------------------

    /// A peer's message, of its log (QoS 1, 2, retained) or forwarded (QoS 0): queue it for the own
    /// subscribers, take a retained one into the store. Log messages of one peer come in order;
    /// repeated positions are ignored.
    void on_peer_message(Instant now, const MessagePtr& message, Actions& out);

    /// How far the publishes of a peer's log have been worked through.
    [[nodiscard]] Seq cursor(const LogId& log) const;
    /// Of all logs, also of those that nobody holds here any more.
    [[nodiscard]] std::vector<LogPosition> cursors() const;
    /// Appends a Cursor event, when a cursor moved since the last one.
    void append_cursors(Actions& out);
    /// Takes note that the log has been worked through up to `through` although it held no
    /// publishes there.
    void advance_cursor(const LogPosition& through);
    /// Nothing of these logs can come here any more: forgets how far they were worked through, and
    /// what sessions still awaited of them.
    void forget_logs(const std::function<bool(const LogId&)>& are_over, Actions& out);

    /// Becomes the home of the session: appends SessionPut, queues the `missed` messages that match
    /// its subscriptions, in order, and sends again what was in flight (PUBLISH with DUP). An own
    /// session of the same client id stays unless the image outranks() it: returns false then. The
    /// copy that stays takes from the other what the client knows or has from that (two_copies.h).
    ///
    /// `missed`: what this broker has worked through and the image's `worked_through` has not, of
    /// all logs, the own one included. The other way round needs nothing: what the image is ahead
    /// of is skipped for this session when it comes here.
    ///
    /// `moved`: where the image's home said that it goes here (SessionMoved); none when that is
    /// dead. `ours`: the own copy, caught up, which was on its way from here and is not there.
    bool adopt(Instant now, SessionImage image, std::vector<MessagePtr> missed, Actions& out,
               const std::optional<LogPosition>& moved = std::nullopt,
               std::optional<SessionImage> ours = std::nullopt);

    /// The image as adopt() would take it, for another home that lacks what was `missed` and may
    /// lack the logs that it stands in: queued, and worked through as far as this broker is.
    [[nodiscard]] SessionImage caught_up(SessionImage image, std::span<const MessagePtr> missed);

    /// Who is asked whether a peer wants a QoS 0 message; it must outlive this broker.
    void set_audience(const Audience& peers);
    /// Whether nothing leaves from a service address for now. No exchange is begun there (P3:
    /// another home may begin it under another msg id) before send_again() or begin_waiting().
    /// Asked where one would begin: something waits for that client.
    void set_silence(std::function<bool(const SessionHeader& client, Instant now)> is_silent);

    /// Stops being the home: appends SessionErased and forgets, publishing no will. Empty when
    /// unknown.
    std::optional<SessionImage> release(std::string_view client_id, Actions& out);

    /// Stops being the home, for the broker with that log: appends SessionMoved and forgets,
    /// publishing no will. Returns the session as that one adopts it, its epoch raised by `epochs`.
    /// Empty when unknown.
    std::optional<SessionImage> move_away(std::string_view client_id, const LogId& to,
                                          std::uint64_t epochs, Actions& out);
    /// Appends that this session, which was never here, goes to the broker with that log. `moved`:
    /// the event by which it came.
    void pass_on(const SessionImage& image, const LogId& to,
                 const std::optional<LogPosition>& moved, Actions& out);
    /// Appends how the client's session is now: the log does not say else when it was last heard.
    void append_header(std::string_view client_id, Actions& out);
    /// Appends that all sessions of the address have gone there.
    void seal(const Endpoint& address, const LogId& to, Actions& out);

    /// What was sent from `via` lately reached nobody: what is in flight goes out once more, and
    /// what waits is begun. Looks at `most` sessions, from that number on, and returns the next
    /// number; none when it was the last.
    std::optional<std::uint32_t> send_again(Instant now, const Endpoint& via, std::uint32_t from,
                                            std::size_t most, Actions& out);
    /// Begins what waits as nothing left for a while, at all addresses; in the same pieces.
    std::optional<std::uint32_t> begin_waiting(Instant now, std::uint32_t from, std::size_t most,
                                               Actions& out);

    /// True when a datagram that came from there to `via` would reach a session that is homed here,
    /// or one that is being begun; or is known to reach none: it comes from where one was left
    /// behind.
    [[nodiscard]] bool serves(const Endpoint& via, const Endpoint& from, Bytes datagram) const;
    /// True when it would reach a session that is homed here and was heard at that very place, or
    /// that it names.
    [[nodiscard]] bool has_session_at(const Endpoint& via, const Endpoint& from,
                                      Bytes datagram) const;
    /// Some client is connected from that address, to whichever service address.
    [[nodiscard]] bool has_client_at(const ClientAddress& address) const;

    [[nodiscard]] std::optional<SessionImage> image(std::string_view client_id) const;
    /// Of the session that is homed here; null when there is none. Valid until the next input.
    [[nodiscard]] const SessionHeader* header(std::string_view client_id) const;
    [[nodiscard]] std::vector<SessionImage> images() const;  // by client id
    /// The same order in every replay.
    [[nodiscard]] std::vector<ClientId> client_ids() const;
    /// Calls `look` for those of `most` session numbers, from that one on, and returns the next
    /// number; none when it was the last.
    [[nodiscard]] std::optional<std::uint32_t> visit_client_ids(
        std::uint32_t from, std::size_t most,
        const std::function<void(const ClientId&)>& look) const;
    [[nodiscard]] std::vector<ClientId> client_ids_via(const Endpoint& via) const;
    [[nodiscard]] bool is_home_of_any_via(const Endpoint& via) const;

    /// Sets a retained message of the broker itself under $SYS; neither logged nor forwarded.
    void set_system_topic(Instant now, std::string_view topic, Bytes payload, Actions& out);

    // --- for what its owner runs beside it (BrokerOptions::observed_topics)
    // -------------------------------------------------------------------------

    /// Publishes as the broker itself: like a client's publish, for the peers as well. With an
    /// `origin`, if what came from there may be published.
    void publish(Instant now, std::string_view topic, Bytes payload, mqttsn::Qos qos, bool retain,
                 Actions& out, std::string_view origin = {});
    /// What waits in the session that the owner reads (BrokerOptions::read_by_owner), in order,
    /// QoS 1 and 2. Valid until the next input.
    [[nodiscard]] std::span<const Delivery> unread() const;
    /// The owner is done with that one.
    void on_read(Instant now, const LogPosition& position, Actions& out);
    /// The retained messages whose topics match, by topic.
    [[nodiscard]] std::vector<MessagePtr> retained(std::string_view filter) const;
    /// While held, no new message is sent to the client: they wait in its queue, those of QoS 0
    /// too. A session that comes from elsewhere, or is begun anew, is not held.
    void hold(Instant now, std::string_view client_id, bool held, Actions& out);

    /// While set, whatever would have to be promised is answered by "congestion": CONNECT,
    /// SUBSCRIBE, PUBLISH of QoS 1 and 2.
    void set_congested(bool congested);
    /// While set, nothing is taken that stays: the same answer, also to a new topic id, a retained
    /// message and a will; and QoS 0 is not kept for whoever cannot be sent it at once. What peers
    /// bring was promised by them and is taken. With each datagram a session goes whose client is
    /// away (Lifecycle::make_room). For an owner that is short of memory.
    void set_full(bool full);
    /// The Sends so far that had to wait for events after `safe` were dropped: what follows need
    /// not wait behind them.
    void on_output_dropped(Seq safe);

    /// By topic; not $SYS. A deleted one is an empty payload.
    [[nodiscard]] std::vector<MessagePtr> retained() const;
    /// The retained message that was published there, or null.
    [[nodiscard]] MessagePtr retained_at(const LogPosition& position) const;
    /// A peer's retained message from a snapshot: kept when later than ours, not delivered.
    void put_retained(const MessagePtr& message);

    [[nodiscard]] Seq last_seq() const;
    void observe_time(HybridTime time);
    [[nodiscard]] const Limits& limits() const;
    [[nodiscard]] const Counters& counters() const;
    [[nodiscard]] Census census() const;
    [[nodiscard]] std::size_t session_count() const;
    [[nodiscard]] std::size_t connected_count() const;

    /// Asserts what must hold between the tables; the simulator calls it after every step.
    void check_invariants() const;

private:
    class State;
    std::unique_ptr<State> state_;
};

}  // namespace romano::broker
