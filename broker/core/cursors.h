// How far this broker has worked through the publishes of each peer's log, and how far its own log
// says so.
#pragma once

#include <algorithm>
#include <map>
#include <vector>

#include "broker/core/log_position.h"

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
        const auto found = by_log_.find(log);
        return found == by_log_.end() ? 0 : found->second.through;
    }

    /// False when the position was passed before.
    bool advance(const LogPosition& position) {
        Cursor& cursor = by_log_[position.log];
        if (position.seq <= cursor.through) return false;
        cursor.through = position.seq;
        return true;
    }

    /// The own log says so: by a Routed or a Cursor event.
    void logged(const LogPosition& position) {
        Cursor& cursor = by_log_[position.log];
        cursor.logged = std::max(cursor.logged, position.seq);
    }

    /// Nothing can come of these logs any more.
    template <typename IsOver>
    void forget(IsOver&& is_over) {
        std::erase_if(by_log_, [&](const auto& entry) { return is_over(entry.first); });
    }
    [[nodiscard]] std::size_t size() const { return by_log_.size(); }

    /// Those that the own log does not know yet.
    [[nodiscard]] std::vector<LogPosition> unlogged() const {
        std::vector<LogPosition> found;
        for (const auto& [log, cursor] : by_log_) {
            if (cursor.through > cursor.logged) found.push_back({log, cursor.through});
        }
        return found;
    }

    [[nodiscard]] std::vector<LogPosition> all() const {
        std::vector<LogPosition> found;
        for (const auto& [log, cursor] : by_log_) found.push_back({log, cursor.through});
        return found;
    }

private:
    struct Cursor {
        Seq through = 0;
        Seq logged = 0;
    };
    std::map<LogId, Cursor> by_log_;
};

}  // namespace romano::broker
