// What the peers' sessions want, where they are, and which are slow: the tables that follow the
// events of logs which go on. A log that has ended is followed no more; its interest is forgotten,
// and where its sessions were, and which were slow, stays until a living home takes its place.
#pragma once

#include <map>
#include <string_view>
#include <vector>

#include "broker/core/audience.h"
#include "overlay/cluster/ownership/homes.h"
#include "overlay/cluster/replication/interest.h"
#include "overlay/cluster/replication/peer_log.h"
#include "overlay/cluster/replication/slow_receivers.h"

namespace romano::cluster {

class PeerSessions final : public broker::Audience {
public:
    [[nodiscard]] bool wants(std::string_view topic) const override {
        return interest_.wants(topic);
    }
    [[nodiscard]] std::size_t longest_queue(std::string_view topic, Instant since) const override {
        return slow_.longest_queue(topic, since);
    }
    [[nodiscard]] bool share_address_with(const broker::SessionHeader& own) const override {
        return homes_.share_address_with(own);
    }
    [[nodiscard]] const Interest& interest() const { return interest_; }
    [[nodiscard]] const Homes& homes() const { return homes_; }

    /// The next event of a log that goes on, before its mirror applies it. Receivers with more than
    /// `many` messages waiting are slow.
    void on_event(Instant now, const broker::Mirror& sessions, const broker::LogEvent& event,
                  std::size_t many);
    /// An event of a log that has ended: the tables lack it.
    void on_late_event(const LogId& log);
    /// The next part of the snapshot of a log of which nothing was known, and what earlier parts
    /// said of its sessions.
    void on_first_snapshot(const SnapshotPart& part,
                           const std::vector<broker::SessionImage>& replaced);
    /// Replaces all that is known of this life of the log's broker. Where the clients of a former
    /// one were stays.
    void reset(const LogId& log, const broker::Mirror& sessions);
    /// The tables have all sessions of that log.
    [[nodiscard]] bool follow(const LogId& log) const;
    /// It has ended. What its sessions wanted is forgotten in the next turns.
    void on_end(const LogId& log);
    void on_turn() { interest_.on_turn(); }
    /// It is not held any more.
    void forget(const LogId& log);
    /// The client has a living home: what ended logs say of it is over.
    void on_living_home(const broker::ClientId& client, const PeerLogs& logs);
    /// That is this broker.
    void on_own_session(const broker::ClientId& client, const PeerLogs& logs);

private:
    void unfollow(const LogId& log);

    Interest interest_;
    Homes homes_;
    SlowReceivers slow_;
    std::map<BrokerId, LogId> followed_;
    std::map<BrokerId, LogId> ended_;  // last, of those where homes_ has what it said
};

}  // namespace romano::cluster
