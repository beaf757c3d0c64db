// What a client published at its former home comes before what it publishes at the next one.
//
// The two stand in two logs, and after a heal, or when a batch is lost, the second may be here
// first. A log that goes on with a session from elsewhere therefore hands its next publishes on
// when the other logs are worked through as far as its writer had worked through them then. Their
// events are applied and acknowledged meanwhile: only subscribers wait. Not in vain: no log waits
// for what came after it, none for one that is neither held nor a member's who was not met yet, and
// none for longer than a tail takes to come.
//
// A snapshot does not tell which of its publishes followed what. Those of a broker from which we
// were parted wait for all that its sessions have worked through and for all that the other living
// brokers are known to have written by then, and no longer than a session that comes waits for what
// its former home had (arrivals.h): it would go on here before them. Logs that wait for each
// other, and have come so far, go on with what was published first. Nothing waits where we are new
// ourselves: no session here is older.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "overlay/cluster/effects.h"
#include "overlay/cluster/replication/peer_log.h"

namespace romano::cluster {

class PublishOrder {
public:
    explicit PublishOrder(BrokerId self) : self_(self) {}

    /// `writer` is about to apply a SessionPut of this image.
    void on_session(const Effects& effects, const PeerLog& writer,
                    const broker::SessionImage& image, const PeerLogs& logs, const View& view);
    /// A part of a snapshot: its publishes are handed on, now or later.
    void on_snapshot(Effects& effects, const SnapshotPart& part, const PeerLogs& logs);
    /// All publishes that are in it have followed.
    void on_snapshot_end(Effects& effects, const LogPosition& as_of);
    /// Hands the publish of a peer's log on to the broker, now or later.
    void on_publish(Effects& effects, const MessagePtr& message);
    /// The next carry_on() may hand that many on, beside twice as many as came to wait.
    void allow(std::size_t publishes) { allowed_ += publishes; }
    /// Hands on what waits no more, as far as it may.
    void carry_on(Effects& effects, const PeerLogs& logs, const View& view);
    /// What is not handed on yet counts not.
    [[nodiscard]] bool is_worked_through(const Effects& effects, const LogPosition& position,
                                         const PeerLogs& logs, const View& view) const;
    /// There was more that waits no more.
    [[nodiscard]] bool is_behind() const { return is_behind_; }
    /// Hands on all that waits.
    void release_all(Effects& effects);

    static constexpr std::size_t held_most = 20'000;  // publishes; beyond it, nothing waits

private:
    struct Held {
        std::vector<LogPosition> after;  // by log
        Instant until;
        std::deque<MessagePtr> publishes;
        std::optional<LogPosition> snapshot;  // nothing up to there follows these publishes
    };
    /// Of one log, in its order. When there are several, each has publishes.
    using HeldParts = std::deque<Held>;

    /// A publish of that log waits that is not beyond the position.
    [[nodiscard]] bool holds_up_to(const LogPosition& position) const;
    /// The logs that wait for each other and for nothing that is not here.
    [[nodiscard]] std::vector<LogId> circle(const Effects& effects, const PeerLogs& logs,
                                            const View& view) const;
    /// Hands on what was published first in a circle; returns how many.
    std::size_t hand_on_first(Effects& effects, const std::vector<LogId>& circle, std::size_t most);
    /// Returns how many it handed on.
    std::size_t hand_on(Effects& effects, Held& held, std::size_t most);
    void finish(Effects& effects, const Held& held);

    BrokerId self_;
    std::map<LogId, HeldParts> by_log_;  // mostly empty; no deque is
    std::size_t held_ = 0;
    std::size_t allowed_ = 0;
    bool is_behind_ = false;
};

}  // namespace romano::cluster
