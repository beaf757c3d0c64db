#include "overlay/cluster/agreement/ended_logs.h"

#include <algorithm>
#include <iterator>

namespace romano::cluster {

void EndedLogs::on_view(const View& view, const std::vector<LogPosition>& ends) {
    std::erase_if(ends_, [&](const auto& end) { return view.contains(end.second.log); });
    learn(view, ends);
}

/// Positions of two lives compare by their incarnations, then by their ends: those who held more
/// may be gone, but what they went on from is in their logs.
void EndedLogs::learn(const View& view, const std::vector<LogPosition>& ends) {
    for (const LogPosition& end : ends) {
        if (view.contains(end.log)) continue;
        if (ends_.size() == most && !ends_.contains(end.log.broker)) continue;
        LogPosition& known = ends_.try_emplace(end.log.broker, end).first->second;
        known = std::max(known, end);
    }
}

bool EndedLogs::contains(const LogId& log) const {
    const auto end = ends_.find(log.broker);
    return end != ends_.end() && end->second.log == log;
}

std::vector<LogPosition> EndedLogs::list() const {
    std::vector<LogPosition> all;
    std::ranges::transform(ends_, std::back_inserter(all),
                           [](const auto& end) { return end.second; });
    return all;
}

}  // namespace romano::cluster
