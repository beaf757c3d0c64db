// What is held of one peer's log: the mirror made by applying it in order, and its history.
//
// Batches may come twice, early or not at all. Early ones wait (bounded; the oldest gap is asked
// for anyway, so that overflow drops the newest). When a gap closes there may be much at once: what
// can be applied waits, too, until the cluster core applies it. A frozen log takes nothing from its
// writer any more: its broker is being removed, and the members must agree on its last event; only
// tails that peers send continue it, and no further than to that event. A later view may know of
// more, and agree on a later one.
#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <unordered_set>
#include <vector>

#include "broker/core/mirror.h"
#include "overlay/cluster/messages.h"
#include "overlay/cluster/replication/log_history.h"
#include "romano/base/time.h"

namespace romano::cluster {

class PeerLog {
public:
    PeerLog(LogId id, std::size_t events_kept);

    [[nodiscard]] Seq applied() const { return history_.last(); }
    /// The last event that counts. A process that stood still may hold more of a frozen log than
    /// was agreed on: that counts only if the writer has lived on.
    [[nodiscard]] Seq end() const {
        const bool is_over = frozen_ && agreed_end_ != 0 && !lived_on_;
        return is_over ? std::min(applied(), agreed_end_) : applied();
    }
    [[nodiscard]] const broker::Mirror& mirror() const { return mirror_; }
    [[nodiscard]] broker::Mirror& mirror() { return mirror_; }
    [[nodiscard]] const LogHistory& history() const { return history_; }
    [[nodiscard]] LogHistory& history() { return history_; }
    /// Of the history up to end(), and of what is here beyond it: a snapshot whose last part is to
    /// come, or the last words of a broker whose log was never here.
    [[nodiscard]] std::vector<MessagePtr> publishes_after(Seq seq) const;
    [[nodiscard]] MessagePtr publish_at(Seq seq) const;

    // --- events
    void offer(Seq first_seq, const std::vector<LogEventPtr>& events);
    /// The last event of which none before it is missing, applied or not.
    [[nodiscard]] Seq received() const { return applied() + ready_.size(); }
    /// The next event in order, or none.
    [[nodiscard]] LogEventPtr next() const {
        return ready_.empty() ? LogEventPtr{} : ready_.front();
    }
    [[nodiscard]] bool has_next() const { return !ready_.empty(); }
    void apply();
    /// How far its writer is known to have come.
    [[nodiscard]] Seq known_end() const { return std::max(known_end_, applied()); }
    /// The writer says that its log ends there, and in which view it is.
    void heard_end(Seq last, const ViewNumber& view);

    // --- snapshots
    /// Publishes beyond the events that are here, in log order.
    void offer_ahead(const std::vector<MessagePtr>& publishes);
    /// False when it does not follow the parts that are here.
    [[nodiscard]] bool offer(const SnapshotPart& part);
    /// What earlier parts said of the sessions that the last one speaks of.
    [[nodiscard]] const std::vector<broker::SessionImage>& replaced() const {
        return snapshot_->replaced;
    }
    /// Once the last part is here: replaces mirror and history by the snapshot, and says as of
    /// which event it is.
    [[nodiscard]] std::optional<LogPosition> restart();

    /// Its writer came into a view that we had without it.
    void set_apart(bool was_apart) { was_apart_ = was_apart; }
    [[nodiscard]] bool was_apart() const { return was_apart_; }

    /// Predefined topic ids mean something else to its writer's clients than to ours: its sessions
    /// are never ours.
    void set_foreign(bool foreign) { foreign_ = foreign; }
    [[nodiscard]] bool is_foreign() const { return foreign_; }

    // --- sessions that go to another home
    /// As the writer said that it goes, by the event `at`; null when it has arrived, or was taken
    /// back.
    [[nodiscard]] const MovedSession* moved(const broker::ClientId& client, Seq at) const;
    [[nodiscard]] const std::map<broker::ClientId, MovedSession>& moved() const { return moved_; }
    /// The new home has in its log what the event `at` moved. That event may not be here yet.
    void on_arrived(const broker::ClientId& client, Seq at);
    /// To be called every so often, and within that time a living home takes back what did not
    /// arrive: what it had moved by the last call has arrived, though a snapshot left out the event
    /// that says so.
    void forget_moved();
    /// Of a log that has ended: what went to nobody who is in the view, and did not arrive, is left
    /// here. False while the log of one who is not may say that it did.
    [[nodiscard]] bool call_back(const View& view, const std::map<LogId, PeerLog>& logs);

    // --- removal
    void freeze();
    void thaw();
    [[nodiscard]] bool is_frozen() const { return frozen_; }
    /// Where the members of a view said that it ends; none while they have not, or its writer was
    /// heard in a later one.
    struct AgreedEnd {
        Seq seq = 0;
        ViewNumber in;
    };
    [[nodiscard]] std::optional<AgreedEnd> agreed_end() const {
        if (!frozen_ || lived_on_ || agreed_end_ == 0) return std::nullopt;
        return AgreedEnd{agreed_end_, ended_in_};
    }
    /// We were replaced, or are new: until we promise a view with its writer, others know better
    /// what is left of it. That the writer hears us says nothing: it may have been replaced, too.
    void become_outdated() { outdated_ = true; }
    void promised_with_writer() { outdated_ = outdated_ && frozen_; }
    [[nodiscard]] bool is_outdated() const { return outdated_; }
    /// Of a frozen log: the last event that the members of that view agreed on. Its writer may have
    /// lived on beyond an earlier one, in views that we missed: then what was taken from it is its
    /// own again.
    void end_at(Seq end, const ViewNumber& view);
    [[nodiscard]] bool has_agreed_end() const { return reaches_agreed_end(applied()); }
    [[nodiscard]] bool reaches_agreed_end(Seq through) const { return through >= agreed_end_; }
    /// All up to there is here, or, of a frozen log, all that was agreed on: nothing follows that,
    /// whoever knows of more.
    [[nodiscard]] bool holds(Seq seq) const {
        const bool is_complete = frozen_ && agreed_end_ != 0 && applied() >= agreed_end_;
        return applied() >= seq || is_complete;
    }
    /// The addresses that the writer's beacon names: robots may come there at any time.
    void heard_serving(const std::vector<Endpoint>& addresses) {
        if (!frozen_ && serving_ != addresses) serving_ = addresses;
    }
    /// Of a frozen log: the session has a new home, in another log.
    void mark_taken(const broker::ClientId& client) {
        if (!frozen_) return;
        moved_.erase(client);
        called_back_.erase(client);
        if (mirror_.contains(client)) taken_.insert(client);
    }
    /// Of a frozen log: the address has a new broker.
    void mark_served(const Endpoint& address) { std::erase(serving_, address); }
    /// What there is to go on from, should this log's broker be gone; null when it is not home to
    /// the client, or when the session of a frozen log has a new home, for all we know.
    [[nodiscard]] const broker::SessionHeader* session(const broker::ClientId& client) const {
        const bool is_taken = frozen_ && (outdated_ || taken_.contains(client));
        return is_taken ? nullptr : mirror_.header(client);
    }
    /// Whose sessions of that address have no new home yet.
    [[nodiscard]] std::vector<broker::ClientId> clients_left(const Endpoint& address) const;
    /// None when it has a new home by now.
    [[nodiscard]] std::optional<broker::SessionImage> session_left(
        const broker::ClientId& client) const;
    /// Addresses without a new broker or with sessions left, were that the view.
    [[nodiscard]] std::vector<Endpoint> addresses_left(const View& view) const;

private:
    /// A later view brings that event. Its announcement is on its way, and we fetch the event then.
    [[nodiscard]] bool is_beyond_agreed_end(Seq seq) const;
    /// Takes the events that follow what is here.
    void take(Seq first_seq, const std::vector<LogEventPtr>& events);
    void take_early();
    void follow_in_tail(const LogEvent& event);
    void follow_moves(const LogEvent& event);
    template <typename Look>
    void visit_left(Look&& look) const;

    broker::Mirror mirror_;
    LogHistory history_;
    std::deque<LogEventPtr> ready_;                  // follow applied()
    std::map<Seq, std::vector<LogEventPtr>> early_;  // by first seq; beyond a gap
    std::size_t early_events_ = 0;
    Seq known_end_ = 0;
    /// The parts of a snapshot that have come so far.
    struct Snapshot {
        explicit Snapshot(const SnapshotPart& first)
            : since(first.since), sessions(first.as_of.log) {}

        Seq since;
        std::uint32_t next_part = 0;
        broker::Mirror sessions;
        std::vector<broker::SessionImage> replaced;  // by the last part
        std::map<broker::ClientId, MovedSession> moved;
        std::vector<MessagePtr> publishes;
        std::optional<Seq> as_of;  // once it is whole
    };
    std::optional<Snapshot> snapshot_;
    std::vector<MessagePtr> ahead_;  // beyond applied(), in log order

    std::map<broker::ClientId, MovedSession> moved_;
    std::set<broker::ClientId> called_back_;  // of those: nobody is there to take them
    std::set<Seq> arrived_early_;             // moved by events that are not here yet
    Seq moved_before_ = 0;                    // the last forget_moved()
    bool was_apart_ = false;
    bool foreign_ = false;
    bool frozen_ = false;
    bool outdated_ = false;
    Seq agreed_end_ = 0;
    ViewNumber ended_in_;                         // the first view that agreed on that
    bool lived_on_ = false;                       // its writer was heard in a later one
    std::unordered_set<broker::ClientId> taken_;  // of a frozen log: sessions with a new home
    std::vector<Endpoint> serving_;
};

/// All peers' logs that are held: of members, of peers that are about to join, and for some time of
/// removed ones.
using PeerLogs = std::map<LogId, PeerLog>;

}  // namespace romano::cluster
