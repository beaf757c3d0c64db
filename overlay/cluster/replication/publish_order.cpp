#include "overlay/cluster/replication/publish_order.h"

#include <algorithm>
#include <set>
#include <utility>

#include "broker/core/cursors.h"

namespace romano::cluster {

void PublishOrder::on_session(const Effects& effects, const PeerLog& writer,
                              const broker::SessionImage& image, const PeerLogs& logs,
                              const View& view) {
    std::vector<LogPosition> lacking;
    const auto look_at = [&](const LogId& id) {
        if (id == writer.mirror().log()) return;
        // The writer had worked through so much of it for that session.
        const LogPosition position{
            id, std::max(writer.mirror().cursor(id), broker::worked_through(image, id))};
        if (!is_worked_through(effects, position, logs, view)) lacking.push_back(position);
    };
    for (const auto& [id, log] : logs) look_at(id);
    for (const LogId& id : view.members) {
        if (!logs.contains(id)) look_at(id);
    }
    if (lacking.empty()) return;
    auto& held = by_log_[writer.mirror().log()];
    if (held.empty() || !held.back().publishes.empty()) held.emplace_back();
    held.back().after = broker::later_of(held.back().after, lacking);
    held.back().until = effects.now + effects.times.former_home_waited_for();
}

void PublishOrder::on_snapshot(Effects& effects, const SnapshotPart& part, const PeerLogs& logs) {
    const LogId& log = part.as_of.log;
    if (!part.publishes.empty() && logs.at(log).was_apart()) {
        std::vector<LogPosition> others;
        for (const auto& [id, other] : logs) {
            if (!other.is_frozen()) others.push_back({id, other.known_end()});
        }
        for (const broker::SessionImage& image : part.sessions) {
            others.insert(others.end(), image.worked_through.begin(), image.worked_through.end());
        }
        std::erase_if(others, [&](const LogPosition& position) { return position.log == log; });
        auto& parts = by_log_[log];
        if (parts.empty()) parts.emplace_back();
        parts.back().after = broker::later_of(parts.back().after, others);
        parts.back().until = effects.now + effects.times.snapshot_order_kept_for();
    }
    for (const MessagePtr& message : part.publishes) on_publish(effects, message);
}

void PublishOrder::on_snapshot_end(Effects& effects, const LogPosition& as_of) {
    const auto held = by_log_.find(as_of.log);
    if (held == by_log_.end()) return effects.broker.advance_cursor(as_of);
    held->second.back().snapshot = as_of;
}

bool PublishOrder::is_worked_through(const Effects& effects, const LogPosition& position,
                                     const PeerLogs& logs, const View& view) const {
    if (effects.broker.cursor(position.log) >= position.seq) return true;
    const auto log = logs.find(position.log);
    if (log != logs.end()) return log->second.holds(position.seq) && !holds_up_to(position);
    return position.log.broker == self_ || !view.contains(position.log);
}

bool PublishOrder::holds_up_to(const LogPosition& position) const {
    const auto held = by_log_.find(position.log);
    if (held == by_log_.end()) return false;
    const auto& publishes = held->second.front().publishes;
    return !publishes.empty() && publishes.front()->position.seq <= position.seq;
}

void PublishOrder::on_publish(Effects& effects, const MessagePtr& message) {
    const auto held = by_log_.find(message->position.log);
    if (held == by_log_.end()) {
        return effects.broker.on_peer_message(effects.now, message, effects.clients);
    }
    held->second.back().publishes.push_back(message);
    allowed_ += 2;
    if (++held_ < held_most) return;
    for (auto& [log, parts] : by_log_) {
        for (Held& part : parts) part.until = Instant::min();
    }
}

void PublishOrder::carry_on(Effects& effects, const PeerLogs& logs, const View& view) {
    const auto waits = [&](Held& held) {
        std::erase_if(held.after, [&](const LogPosition& position) {
            return is_worked_through(effects, position, logs, view);
        });
        return !held.after.empty() && effects.now < held.until;
    };
    std::size_t allowed = std::exchange(allowed_, 0);
    is_behind_ = false;
    // One log may wait for another one that waits.
    const auto hand_on_free = [&] {
        for (auto at = by_log_.begin(); at != by_log_.end();) {
            auto& held = at->second;
            if (waits(held.front())) {
                ++at;
                continue;
            }
            allowed -= hand_on(effects, held.front(), allowed);
            if (!held.front().publishes.empty()) return false;
            finish(effects, held.front());
            held.pop_front();
            if (held.empty()) by_log_.erase(at);
            at = by_log_.begin();
        }
        return true;
    };
    while (hand_on_free()) {
        const std::vector<LogId> waiting = circle(effects, logs, view);
        if (waiting.empty()) return;
        const std::size_t count = hand_on_first(effects, waiting, allowed);
        if (count == 0) break;
        allowed -= count;
    }
    is_behind_ = true;
}

std::vector<LogId> PublishOrder::circle(const Effects& effects, const PeerLogs& logs,
                                        const View& view) const {
    // Nobody knows when that comes which is not here: who waits for it, or for one that does, is in
    // no circle.
    std::set<LogId> outside;
    const auto is_in = [&](const LogPosition& position) {
        if (outside.contains(position.log)) {
            return is_worked_through(effects, position, logs, view);
        }
        const auto log = logs.find(position.log);
        return log != logs.end() && log->second.holds(position.seq);
    };
    std::vector<LogId> in;
    for (const auto& [id, parts] : by_log_) {
        if (!parts.front().publishes.empty()) in.push_back(id);
    }
    const auto leave = [&](const LogId& id) {
        return !std::ranges::all_of(by_log_.at(id).front().after, is_in) &&
               outside.insert(id).second;
    };
    while (std::erase_if(in, leave) != 0) {
    }
    return in;
}

std::size_t PublishOrder::hand_on_first(Effects& effects, const std::vector<LogId>& circle,
                                        std::size_t most) {
    const auto next = [this](const LogId& id) {
        return by_log_.at(id).front().publishes.front()->published_at;
    };
    const LogId first = *std::ranges::min_element(circle, {}, next);
    auto& parts = by_log_.at(first);
    Held& held = parts.front();
    const auto is_first = [&](const MessagePtr& message) {
        return std::ranges::all_of(circle, [&](const LogId& other) {
            return other == first || message->published_at <= next(other);
        });
    };
    const auto end = std::ranges::find_if_not(held.publishes, is_first);
    const auto count = static_cast<std::size_t>(end - held.publishes.begin());
    const std::size_t handed_on = hand_on(effects, held, std::min(count, most));
    if (held.publishes.empty() && parts.size() > 1) {
        finish(effects, held);
        parts.pop_front();
    }
    return handed_on;
}

void PublishOrder::release_all(Effects& effects) {
    for (auto& [log, parts] : by_log_) {
        for (Held& part : parts) {
            hand_on(effects, part, part.publishes.size());
            finish(effects, part);
        }
    }
    by_log_.clear();
}

std::size_t PublishOrder::hand_on(Effects& effects, Held& held, std::size_t most) {
    const std::size_t count = std::min(most, held.publishes.size());
    for (std::size_t i = 0; i < count; ++i) {
        effects.broker.on_peer_message(effects.now, held.publishes.front(), effects.clients);
        held.publishes.pop_front();
    }
    held_ -= count;
    return count;
}

void PublishOrder::finish(Effects& effects, const Held& held) {
    if (held.snapshot) effects.broker.advance_cursor(*held.snapshot);
}

}  // namespace romano::cluster
