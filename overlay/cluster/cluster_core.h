// The cluster's side of one broker: composes membership, logs, view change, take-over, hand-back
// and settlement. It acts on the broker core that `Member` lends it with each input (Effects), and
// carries that broker's log to the peers.
//
// `Member` puts every Append of the broker core into append() after each input, and calls flush()
// before it waits for the next one.
//
// No input takes long, however much there is to catch up with: a broker that is busy for too long
// is late for its peers, and taken for dead. What peers sent is applied twice as fast as it comes,
// and some more at each tick; sessions come, and snapshots leave, in pieces.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "overlay/cluster/agreement/acquaintance.h"
#include "overlay/cluster/agreement/ended_logs.h"
#include "overlay/cluster/agreement/heartbeat.h"
#include "overlay/cluster/agreement/leaderless.h"
#include "overlay/cluster/agreement/live_peers.h"
#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/agreement/namesake.h"
#include "overlay/cluster/agreement/settings_comparison.h"
#include "overlay/cluster/agreement/smaller_side.h"
#include "overlay/cluster/agreement/view_change.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/adoption.h"
#include "overlay/cluster/ownership/arrivals.h"
#include "overlay/cluster/ownership/departures.h"
#include "overlay/cluster/ownership/hand_back.h"
#include "overlay/cluster/ownership/roaming.h"
#include "overlay/cluster/ownership/service_addresses.h"
#include "overlay/cluster/ownership/settlement.h"
#include "overlay/cluster/ownership/strays.h"
#include "overlay/cluster/ownership/take_over.h"
#include "overlay/cluster/replication/acknowledgements.h"
#include "overlay/cluster/replication/fetching.h"
#include "overlay/cluster/replication/log_keeping.h"
#include "overlay/cluster/replication/log_sender.h"
#include "overlay/cluster/replication/own_log.h"
#include "overlay/cluster/replication/peer_log.h"
#include "overlay/cluster/replication/peer_sessions.h"
#include "overlay/cluster/replication/publish_order.h"
#include "overlay/cluster/replication/watermark.h"
#include "overlay/cluster/speaking/lease.h"
#include "overlay/cluster/speaking/speaking.h"

namespace romano::cluster {

struct Identity {
    std::string name;
    LogId log;
    std::vector<Endpoint> home_addresses;
    LinkAddress link = {};
    PredefinedTopics predefined = {};
};

class ClusterCore {
public:
    ClusterCore(const ClusterOptions& options, const Identity& identity, std::uint64_t seed);
    ClusterCore(const ClusterCore&) = delete;
    ClusterCore& operator=(const ClusterCore&) = delete;

    // --- inputs
    void on_message(Effects effects, const Envelope& envelope);
    /// `pending_output`: addresses that held-back answers wait to leave from.
    void on_tick(Effects effects, const std::set<Endpoint>& pending_output);
    void on_address(Effects effects, const Endpoint& address, bool served);
    void on_link(Effects effects, const LogId& process, election::Link link);
    /// Battery or load, from 0 to 100.
    void on_condition(Effects effects, std::uint32_t reading);
    /// Whether the shell could serve a peer's address here, should that peer die.
    void on_ability(const Endpoint& address, bool can_take) {
        addresses_.on_ability(address, can_take);
    }
    void on_usage(const Usage& usage) { usage_ = usage; }
    /// Instant::min(): there is more to be done than fits one turn.
    [[nodiscard]] Instant next_wakeup() const;
    /// What does not fit one turn are sessions that move, and nobody waits for them.
    [[nodiscard]] bool may_rest() const;

    // --- the own log
    void append(Seq seq, const LogEventPtr& event);
    /// `awaited`: clients wait until the log is safe up to there.
    void flush(Seq awaited, Outbox& out) { own_.flush(awaited, out); }
    /// To peers with a matching subscriber.
    void forward(const MessagePtr& message, Outbox& out) const;
    [[nodiscard]] const broker::Audience& audience() const { return peer_sessions_; }
    /// The log is held by enough peers up to here.
    Seq safe(Instant now);

    // --- what `Member` must know
    [[nodiscard]] bool is_in_view() const { return view_change_.has_view(); }
    [[nodiscard]] const Speaking& speaking() const { return speaking_; }
    /// The datagram waits for a session that is on its way here with many others: it comes first.
    void hurry(Effects effects, const Endpoint& via, const Endpoint& from, Bytes datagram);
    /// A message waits for the client, whose address is silent: the session leaves first.
    void on_awaited(const broker::SessionHeader& client) { hand_back_.on_awaited(client); }
    /// The datagram's session is at a peer, who is asked for it: it shall wait for that.
    bool must_fetch(Effects effects, const Endpoint& via, const Endpoint& from, Bytes datagram);
    /// The datagram's session is at a peer, or on its way.
    [[nodiscard]] bool is_elsewhere(const broker::BrokerCore& broker, const Endpoint& via,
                                    const Endpoint& from, Bytes datagram) const {
        return roaming_
            .client_elsewhere(broker, {via, from}, datagram, peer_sessions_.homes(), departures_,
                              membership_)
            .has_value();
    }
    [[nodiscard]] bool is_fetching(const Endpoint& via, const Endpoint& from) const {
        return roaming_.is_fetching({via, from});
    }
    /// With acks_strict: there are fewer peers than must hold what is promised to clients.
    [[nodiscard]] bool is_short_of_peers() const;
    /// Since then we are on the smaller side of a cut: whoever was not heard since may be heard by
    /// the others.
    [[nodiscard]] const std::optional<Instant>& on_smaller_side_since() const {
        return smaller_side_.since();
    }
    /// What clients answered may be lost: the next turns repeat what waits for that.
    void say_again_everywhere() {
        for (const Endpoint& address : addresses_.serving()) {
            said_again_.insert_or_assign(address, 0);
        }
    }
    /// A peer says that it is home to the client.
    [[nodiscard]] bool is_homed_at_peer(const broker::ClientId& client) const {
        return peer_sessions_.homes().of(client).has_value();
    }
    /// While it stood still a newer view was made without us, and its members hold all that we
    /// promised to clients: when they do not, we come back with our log, as in a heal.
    [[nodiscard]] bool was_replaced(Instant now) const;
    [[nodiscard]] const View& view() const { return view_change_.view(); }
    [[nodiscard]] const ViewNumber& promised() const { return view_change_.promised(); }
    /// How far this broker says that it holds the log.
    [[nodiscard]] Seq held_of(const LogId& id, const PeerLog& log) const;
    [[nodiscard]] election::Leadership leadership() const { return membership_.leadership(); }
    [[nodiscard]] Times times() const { return membership_.times(); }
    /// The rights of this broker's clients are these now: compared with the peers'.
    void on_rights(const std::string& digest) { settings_.change("rights", digest); }
    [[nodiscard]] const SettingsComparison& settings() const { return settings_; }
    [[nodiscard]] const Membership& membership() const { return membership_; }
    [[nodiscard]] const ServiceAddresses& addresses() const { return addresses_; }
    [[nodiscard]] const PeerLogs& peer_logs() const { return logs_; }
    [[nodiscard]] const OwnLog& own_log() const { return own_; }
    [[nodiscard]] const Watermark& watermark() const { return watermark_; }
    [[nodiscard]] const TakeOver& take_over() const { return take_over_; }
    [[nodiscard]] const Departures& departures() const { return departures_; }
    /// Views that were agreed on so far.
    [[nodiscard]] std::uint64_t views_seen() const { return views_seen_; }
    /// Peers of the view that are alive.
    [[nodiscard]] const std::vector<LogId>& live_peers() const;
    /// The own beacon as it would be sent now.
    [[nodiscard]] Beacon beacon(const broker::BrokerCore& broker) const;

    // --- beginnings and ends
    /// Begins a new log: all sessions and addresses are gone to others. The effects' broker core is
    /// already the new, empty one.
    void restart(Effects effects, LogId log);
    void leave(Effects effects);
    /// To be asked before each input: nothing was done for so long that others may have gone on
    /// meanwhile. True once for each standstill.
    bool notice_standstill(Instant now);
    void send_beacon(Effects& effects);

    void check_invariants(const broker::BrokerCore& broker) const;

private:
    void on(Effects& effects, BrokerId from, const Heartbeat& message);
    void on(Effects& effects, BrokerId from, const Particulars& message);
    void on(Effects& effects, BrokerId from, const Pulse& message);
    void on(Effects& effects, BrokerId from, const LogBatch& message);
    void on(Effects& effects, BrokerId from, const LogAck& message);
    void on(Effects& effects, BrokerId from, const ForwardBatch& message);
    void on(Effects& effects, BrokerId from, const ElectionMessage& message);
    void on(Effects& effects, BrokerId from, const ViewProposal& message);
    void on(Effects& effects, BrokerId from, const ViewHoldings& message);
    void on(Effects& effects, BrokerId from, const ViewAnnouncement& message);
    void on(Effects& effects, BrokerId from, const Fetch& message);
    void on(Effects& effects, BrokerId from, const SnapshotPart& message);
    void on(Effects& effects, BrokerId from, const SessionRequest& message);
    static void on(Effects&, BrokerId, const SecuredTold&) {}

    void say(Effects& effects, const Beacon& beacon);
    void heed(Effects& effects, const Beacon& beacon, Membership::Heard heard);
    void heed_log_of(const Beacon& beacon);
    [[nodiscard]] bool is_back() const { return stood_still_for_ != Duration{}; }
    [[nodiscard]] bool knows_its_place(Instant now) const;
    [[nodiscard]] bool is_for_later(Instant now, const ClusterMessage& message) const;
    /// Acts on news of peers: one came or went, serves other addresses, or may lead now.
    void heed_news_of_peers(Effects& effects);
    enum class Answer : std::uint8_t { at_once, with_the_beacon };
    /// Up to `most` events that are here, and as many sessions as one turn may bring; the rest at
    /// the next ticks.
    void apply(Effects& effects, const LogId& id, PeerLog& log, std::size_t most,
               Answer answer = Answer::at_once);
    [[nodiscard]] Answer answer_to(const LogBatch& batch) const;
    void catch_up(Effects& effects);
    void acknowledge(Effects& effects, const LogId& id, const PeerLog& log) const;
    /// For messages that are held by now, or that nobody will ever bring.
    void acknowledge_what_waited(Effects& effects);
    [[nodiscard]] Acknowledgements::IsHeld is_held() const;
    void heed_arrivals(Effects& effects);
    void reclaim(Effects& effects);
    void compare_addresses(Effects& effects);
    void apply_event(Effects& effects, const LogId& id, PeerLog& log);
    void take_last_publishes(Effects& effects, BrokerId from, const SnapshotPart& part);
    void learn(const MessagePtr& message);
    /// The log's deliveries changed.
    void note_lacking(const LogId& id, const PeerLog& log);
    /// Its new home has the session that this event moved there.
    void on_arrived(const broker::ClientId& client, const LogPosition& moved);
    void mark_taken(const broker::ClientId& client);
    void after_input(Effects& effects);
    void take_view(Effects& effects);
    void on_view(Effects& effects, const ViewAnnouncement& announcement);
    void heed_standstill(Instant now);
    /// What was said from an address while it was silent went nowhere, and nothing was begun there:
    /// catches up with both when the silence is over. Before and after an input is worked through,
    /// so that none is missed.
    void heed_silence();
    void say_again(Effects& effects);
    /// What is done again and again, in this order where several are due.
    enum class Timer : std::size_t { cursors, trim, forget_moved, seek_addresses, beacon };
    static constexpr std::size_t timers = 5;
    [[nodiscard]] Instant due_at(Timer timer) const {
        return due_[static_cast<std::size_t>(timer)];
    }
    /// Does it, and says after how long it is due again.
    Duration on_timer(Effects& effects, Timer timer);
    /// Tries again for addresses that should be served here and are served by nobody.
    void seek_addresses(Effects& effects);
    void warn_when_leaderless(Effects& effects);
    /// Somebody waits for what did not fit the last turn.
    [[nodiscard]] bool is_behind() const;
    void warn_of_foreign_sessions(Effects& effects, const ViewAnnouncement& announcement);
    void trim(Effects& effects);
    void forget_old_lives(Effects& effects);
    /// Its sender is in our view, and in a later one without us.
    [[nodiscard]] bool leaves_out(const Beacon& beacon) const;
    [[nodiscard]] Surroundings surroundings(const Effects& effects);
    [[nodiscard]] Logs logs() { return {logs_, own_}; }

    ClusterOptions options_;
    std::string name_;
    LinkAddress link_;
    OwnLog own_;
    HeartbeatWriter heartbeats_;
    HeartbeatReader peers_beacons_;
    Membership membership_;
    ServiceAddresses addresses_;
    std::set<LogId> without_heir_;  // nobody goes on for their clients, and people know
    PeerLogs logs_;
    Acknowledgements acknowledgements_;
    LogKeeping keeping_;
    PublishOrder publish_order_;
    PeerSessions peer_sessions_;
    Watermark watermark_;
    Lease lease_;
    ViewChange view_change_;
    Acquaintance acquaintance_;
    TakeOver take_over_;
    Fetching fetching_;
    HandBack hand_back_;
    Strays strays_;
    Arrivals arrivals_;
    Departures departures_;
    Speaking speaking_;
    Settlement settlement_;
    Roaming roaming_;
    EndedLogs ended_;
    LogSender log_sender_;
    mutable LivePeers live_peers_;
    bool has_frozen_logs_ = false;                  // as of the last tick
    std::set<Endpoint> silent_;                     // of those that are served, or were then
    std::map<Endpoint, std::uint32_t> said_again_;  // up to which session
    std::uint32_t predefined_;                      // digest
    SettingsComparison settings_;

    /// Back from a standstill: others may have gone on for us, and what we are asked or told may be
    /// as old. Zero while there was a lease since.
    Duration stood_still_for_{};
    /// What the own addresses were compared with last: the peers' news, the view, and what was
    /// served.
    std::optional<std::tuple<std::uint64_t, ViewNumber, std::set<Endpoint>>> compared_;
    SmallerSide smaller_side_;
    Namesake namesake_;
    Leaderless leaderless_;
    /// Logs with events that wait to be applied: so many of them had to wait for sessions only.
    std::map<LogId, std::size_t> behind_;
    std::map<LogId, std::size_t> sessions_brought_;  // by their logs in this turn
    std::set<LogId> lacking_;  // logs with deliveries of messages that are not here
    std::array<Instant, timers> due_;
    std::uint64_t views_seen_ = 0;
    std::uint64_t beacons_sent_ = 0;
    Usage usage_;
    election::Leadership last_leadership_;  // as the last beacon said
    ViewNumber last_view_;
};

}  // namespace romano::cluster
