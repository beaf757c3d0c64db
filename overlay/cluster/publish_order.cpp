#include "overlay/cluster/publish_order.h"

#include <algorithm>
#include <set>
#include <utility>

#include "broker/core/cursors.h"

namespace romano::cluster {
namespace {

/// How far the writer had worked through `log` for that session.
Seq worked_through(const PeerLog& writer, const broker::SessionImage& image, const LogId& log) {
    const auto ahead = std::ranges::find(image.worked_through, log, &LogPosition::log);
    return std::max(writer.mirror().cursor(log),
                    ahead == image.worked_through.end() ? 0 : ahead->seq);
}

}  // namespace

void PublishOrder::on_session(const Effects& effects, const PeerLog& writer,
                              const broker::SessionImage& image, const PeerLogs& logs,
                              const View& view) {
    std::set<LogId> others{view.members.begin(), view.members.end()};
    for (const auto& [id, log] : logs) others.insert(id);
    others.erase(writer.mirror().log());
    std::vector<LogPosition> lacking;
    for (const LogId& id : others) {
        const LogPosition position{id, worked_through(writer, image, id)};
        if (!is_worked_through(effects, position, logs, view)) lacking.push_back(position);
    }
    if (lacking.empty()) return;
    auto& held = by_log_[writer.mirror().log()];
    if (held.empty() || !held.back().publishes.empty()) held.emplace_back();
    held.back().after = broker::later_of(held.back().after, lacking);
    held.back().until = effects.now + patience_;
}

bool PublishOrder::is_worked_through(const Effects& effects, const LogPosition& position,
                                     const PeerLogs& logs, const View& view) const {
    if (effects.broker.cursor(position.log) >= position.seq) return true;
    const auto log = logs.find(position.log);
    if (log != logs.end()) return log->second.applied() >= position.seq && !holds_up_to(position);
    return position.log.broker == self_ || !view.contains(position.log);
}

bool PublishOrder::holds_up_to(const LogPosition& position) const {
    const auto held = by_log_.find(position.log);
    if (held == by_log_.end()) return false;
    const auto& parts = held->second;
    const auto first =
        std::ranges::find_if_not(parts, [](const Held& part) { return part.publishes.empty(); });
    return first != parts.end() && first->publishes.front()->position.seq <= position.seq;
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
    for (auto at = by_log_.begin(); at != by_log_.end();) {
        auto& held = at->second;
        if (waits(held.front())) {
            ++at;
            continue;
        }
        allowed -= hand_on(effects, held.front(), allowed);
        is_behind_ = !held.front().publishes.empty();
        if (is_behind_) return;
        held.pop_front();
        if (held.empty()) by_log_.erase(at);
        at = by_log_.begin();
    }
}

void PublishOrder::release(Effects& effects, const LogId& log) {
    const auto held = by_log_.extract(log);
    if (held.empty()) return;
    for (Held& part : held.mapped()) hand_on(effects, part, part.publishes.size());
}

void PublishOrder::release_all(Effects& effects) {
    while (!by_log_.empty()) release(effects, by_log_.begin()->first);
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

}  // namespace romano::cluster
