// Whom a view brings together. A newcomer has met its leader, and the other members perhaps not
// yet: one of them may be home to the robots at its address. And one that comes into a view that
// others had without it may bring what was published while they were parted.
#pragma once

#include <algorithm>
#include <vector>

#include "overlay/cluster/messages.h"
#include "overlay/cluster/peer_log.h"

namespace romano::cluster {

class Acquaintance {
public:
    /// Whose logs are held is met. Marks those of members from whom we were parted.
    void on_view(const LogId& self, const View& view, PeerLogs& logs) {
        const bool is_new_here = members_.empty();
        if (is_new_here) unmet_ = view.members;
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
    /// It is heard.
    void meet(const LogId& log) { std::erase(unmet_, log); }
    /// All who took us into our first view are met, or were removed.
    [[nodiscard]] bool has_met_all() const { return unmet_.empty(); }
    void restart() {
        members_.clear();
        unmet_.clear();
    }

private:
    std::vector<LogId> members_;  // of the last view
    std::vector<LogId> unmet_;
};

}  // namespace romano::cluster
