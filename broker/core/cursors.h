// How far this broker has worked through the publishes of each peer's log, and how far its own log
// says so.
#pragma once

#include <algorithm>
#include <map>
#include <vector>

#include "broker/core/log_position.h"
#include "romano/base/flat_map.h"

namespace romano::broker {

/// The later position of each log, sorted by log.
[[nodiscard]] inline std::vector<LogPosition> later_of(const std::vector<LogPosition>& a,
                                                       const std::vector<LogPosition>& b) {
    std::map<LogId, Seq> latest;
    for (const auto* positions : {&a, &b}) {
        for (const LogPosition& position : *positions) {
            Seq& seq = latest[position.log];
            seq = std::max(seq, position.seq);
        }
    }
    std::vector<LogPosition> merged;
    for (const auto& [log, seq] : latest) {
        if (seq != 0) merged.push_back({log, seq});
    }
    return merged;
}

class Cursors {
public:
    [[nodiscard]] Seq at(const LogId& log) const {
        const auto found = std::ranges::lower_bound(through_, log, {}, &LogPosition::log);
        return found == through_.end() || found->log != log ? 0 : found->seq;
    }

    /// False when the position was passed before.
    bool advance(const LogPosition& position) {
        const auto known = std::ranges::lower_bound(through_, position.log, {}, &LogPosition::log);
        if (known == through_.end() || known->log != position.log) {
            through_.insert(known, position);
            return position.seq > 0;
        }
        if (position.seq <= known->seq) return false;
        known->seq = position.seq;
        return true;
    }

    /// The own log says so: by a Routed or a Cursor event.
    void logged(const LogPosition& position) {
        Seq& seq = logged_[position.log];
        seq = std::max(seq, position.seq);
    }

    /// Nothing can come of these logs any more.
    template <typename IsOver>
    void forget(IsOver&& is_over) {
        std::erase_if(through_, [&](const LogPosition& cursor) { return is_over(cursor.log); });
        erase_if(logged_, [&](const auto& entry) { return is_over(entry.first); });
    }
    [[nodiscard]] std::size_t size() const { return through_.size(); }

    /// Those that the own log does not know yet.
    [[nodiscard]] std::vector<LogPosition> unlogged() const {
        std::vector<LogPosition> found;
        for (const LogPosition& cursor : through_) {
            const auto logged = logged_.find(cursor.log);
            if (cursor.seq > (logged == logged_.end() ? 0 : logged->second)) {
                found.push_back(cursor);
            }
        }
        return found;
    }

    /// By log.
    [[nodiscard]] const std::vector<LogPosition>& all() const { return through_; }

private:
    std::vector<LogPosition> through_;  // by log
    FlatMap<LogId, Seq> logged_;
};

}  // namespace romano::broker
