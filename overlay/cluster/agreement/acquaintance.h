// Whom a view brings together. A newcomer has met its leader, and the other members perhaps not
// yet: one of them may be home to the robots at its address. And one that comes into a view that
// others had without it may bring what was published while they were parted.
//
// Whose robots are whose, a newcomer knows when it has read what the members had written by then:
// until that a stranger may be a robot that roams.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "overlay/cluster/messages.h"
#include "overlay/cluster/replication/peer_log.h"
#include "overlay/cluster/times.h"

namespace romano::cluster {

class Acquaintance {
public:
    /// Whose logs are held is met. Marks those of members from whom we were parted.
    void on_view(Instant now, const Times& times, const LogId& self, const View& view,
                 PeerLogs& logs) {
        const bool is_new_here = members_.empty();
        if (is_new_here) {
            unmet_ = view.members;
            reads_until_ = now + times.members_read_within();
            for (const LogId& member : view.members) {
                if (member != self) unread_.emplace(member, std::nullopt);
            }
        }
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
    /// It is heard, and says where its log ends.
    void meet(const LogId& log, Seq end) {
        std::erase(unmet_, log);
        const auto unread = unread_.find(log);
        if (unread != unread_.end() && !unread->second) unread->second = end;
    }
    void carry_on(Instant now, const PeerLogs& logs) {
        if (now >= reads_until_) unread_.clear();
        std::erase_if(unread_, [&](const auto& entry) {
            const auto log = logs.find(entry.first);
            return entry.second && log != logs.end() && log->second.holds(*entry.second);
        });
    }
    /// All who took us into our first view are met, or were removed.
    [[nodiscard]] bool has_met_all() const { return unmet_.empty(); }
    /// It may be home at a member whose log is not read yet: whoever has no session here.
    [[nodiscard]] bool may_roam() const { return !unread_.empty(); }

private:
    std::vector<LogId> members_;  // of the last view
    std::vector<LogId> unmet_;
    std::map<LogId, std::optional<Seq>> unread_;  // up to there, once its writer said where
    Instant reads_until_ = never;
};

}  // namespace romano::cluster
