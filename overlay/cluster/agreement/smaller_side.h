// Whether this broker is on the smaller side of a cut: it lost more members by silence than its
// view has. Their clients, and ours that they reach, may well live on there: the silence of such a
// client here is no sign of its loss.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <set>

#include "overlay/cluster/messages.h"
#include "romano/base/time.h"

namespace romano::cluster {

class SmallerSide {
public:
    /// `has_ended(member)`: that process is known to be gone; it did not just fall silent.
    void on_view(Instant now, const View& view,
                 const std::function<bool(const LogId& member)>& has_ended) {
        missing_.merge(members_);
        members_ = {view.members.begin(), view.members.end()};
        std::erase_if(missing_, [&](const LogId& member) {
            return members_.contains(member) || has_ended(member);
        });
        if (missing_.size() <= members_.size()) {
            missing_.clear();
            since_.reset();
        } else if (!since_) {
            since_ = now;
        }
    }
    [[nodiscard]] const std::optional<Instant>& since() const { return since_; }

private:
    std::set<LogId> members_;  // of the view
    std::set<LogId> missing_;  // that fell silent in it or before
    std::optional<Instant> since_;
};

}  // namespace romano::cluster
