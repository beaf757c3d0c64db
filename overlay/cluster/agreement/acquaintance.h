// Whom a view brings together. A newcomer has met its leader, and the other members perhaps not
// yet: one of them may be home to the robots at its address. And one that comes into a view that
// others had without it may bring what was published while they were parted.
//
// A broker that had no lease may have been replaced meanwhile. A leader that it hears may take it
// in again while it does not hear who speaks in its place. That one speaks on until the view comes
// there, or its lease in the former view is over. So the broker that is back says nothing before it
// knows what each member says now, or a detection time has passed (I1).
//
// A newcomer knows whose robots are whose when it has read what the members had written by then:
// until that a stranger may be a robot that roams. A log is read when the messages that it names
// are here as well (I6): a session that came earlier would go on without them (P2), though its home
// still has those that all others forgot (fetching.h).
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "overlay/cluster/messages.h"
#include "overlay/cluster/replication/peer_log.h"
#include "overlay/cluster/times.h"

namespace romano::cluster {

class Acquaintance {
public:
    /// We have met a member when we hold its log. The logs of members that our last view lacked
    /// are marked as apart. `had_lease`: we held one until now.
    void on_view(Instant now, const Times& times, const LogId& self, const View& view,
                 bool had_lease, PeerLogs& logs) {
        const bool is_new_here = members_.empty();
        if (is_new_here) {
            unmet_ = view.members;
            reads_until_ = now + times.members_read_within();
            for (const LogId& member : view.members) {
                if (member != self) unread_.emplace(member, std::nullopt);
            }
        }
        if (!is_new_here && !had_lease) {
            unheard_ = view.members;
            std::erase(unheard_, self);
            returns_until_ = now + times.detection;
        }
        std::erase_if(unheard_, [&](const LogId& member) { return !view.contains(member); });
        std::erase_if(unread_, [&](const auto& entry) { return !view.contains(entry.first); });
        std::erase_if(unmet_, [&](const LogId& member) {
            return member == self || logs.contains(member) || !view.contains(member);
        });
        for (const LogId& member : view.members) {
            const auto log = logs.find(member);
            if (log == logs.end()) continue;
            log->second.set_apart(!is_new_here && std::ranges::count(members_, member) == 0);
        }
        members_ = view.members;
    }
    /// The writer is heard, and says where its log ends.
    void meet(const LogId& log, Seq end) {
        std::erase(unmet_, log);
        const auto unread = unread_.find(log);
        if (unread != unread_.end() && !unread->second) unread->second = end;
    }
    /// We know all that this member says now.
    using IsKnown = std::function<bool(const LogId&)>;
    void carry_on(Instant now, const PeerLogs& logs, const IsKnown& is_known) {
        std::erase_if(unheard_, is_known);
        if (now >= reads_until_) unread_.clear();
        std::erase_if(unread_, [&](const auto& entry) {
            const auto log = logs.find(entry.first);
            return entry.second && log != logs.end() && log->second.holds(*entry.second) &&
                   !log->second.mirror().is_any_unresolved();
        });
    }
    /// All who took us into our first view are met, or were removed.
    [[nodiscard]] bool has_met_all() const { return unmet_.empty(); }
    /// Others may still speak in our place.
    [[nodiscard]] bool is_returning(Instant now) const {
        return !unheard_.empty() && now < returns_until_;
    }
    /// A client without a session here may be homed at a member whose log is not read yet.
    [[nodiscard]] bool may_roam() const { return !unread_.empty(); }

private:
    std::vector<LogId> members_;  // of the last view
    std::vector<LogId> unmet_;
    std::vector<LogId> unheard_;
    Instant returns_until_ = never;
    std::map<LogId, std::optional<Seq>> unread_;  // up to there, once its writer said where
    Instant reads_until_ = never;
};

}  // namespace romano::cluster
