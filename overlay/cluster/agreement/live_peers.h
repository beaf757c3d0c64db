// The members of the view that are alive, looked up when either has changed: each message that
// comes asks for them several times, and there may be a hundred.
#pragma once

#include <cstdint>
#include <vector>

#include "overlay/cluster/agreement/membership.h"

namespace romano::cluster {

class LivePeers {
public:
    [[nodiscard]] const std::vector<LogId>& of(const View& view, const Membership& membership) {
        if (view.number == view_ && view.members.size() == members_ &&
            membership.changes() == changes_) {
            return alive_;
        }
        view_ = view.number;
        members_ = view.members.size();
        changes_ = membership.changes();
        alive_.clear();
        for (const LogId& member : view.members) {
            if (membership.is_alive(member)) alive_.push_back(member);
        }
        ++version_;
        return alive_;
    }
    /// Another one whenever others may be alive.
    [[nodiscard]] std::uint64_t version() const { return version_; }

private:
    ViewNumber view_;
    std::size_t members_ = 0;  // a broker that was replaced is in no view, and keeps its number
    std::uint64_t changes_ = 0;
    std::vector<LogId> alive_;
    std::uint64_t version_ = 0;
};

}  // namespace romano::cluster
