#include "overlay/cluster/replication/acknowledgements.h"

namespace romano::cluster {

void Acknowledgements::on_event(const broker::LogId& log, broker::Seq seq,
                                const broker::LogEvent& event, const IsHeld& is_held) {
    if (const auto* routed = std::get_if<broker::Routed>(&event)) {
        wait(log, seq, routed->message, is_held);
    } else if (const auto* put = std::get_if<broker::SessionPut>(&event)) {
        on_session(log, seq, put->image, is_held);
    }
}

void Acknowledgements::on_session(const broker::LogId& log, broker::Seq seq,
                                  const broker::SessionImage& session, const IsHeld& is_held) {
    for (const auto& delivery : session.deliveries) {
        if (delivery.position.log != log) wait(log, seq, delivery.position, is_held);
    }
}

void Acknowledgements::wait(const broker::LogId& log, broker::Seq seq,
                            const broker::LogPosition& publish, const IsHeld& is_held) {
    if (is_held(log, publish)) return;
    auto& waiting = waiting_[log];
    if (waiting.size() < waiting_most) waiting.push_back({seq, publish});
}

broker::Seq Acknowledgements::through(const broker::LogId& log, broker::Seq applied,
                                      const IsHeld& is_held) const {
    const auto found = waiting_.find(log);
    if (found == waiting_.end()) return applied;
    for (const auto& [seq, publish] : found->second) {
        if (!is_held(log, publish)) return seq - 1;
    }
    return applied;
}

std::vector<broker::LogId> Acknowledgements::advance(const IsHeld& is_held) {
    std::vector<broker::LogId> advanced;
    for (auto& [log, waiting] : waiting_) {
        const std::size_t before = waiting.size();
        while (!waiting.empty() && is_held(log, waiting.front().publish)) waiting.pop_front();
        if (waiting.size() < before) advanced.push_back(log);
    }
    std::erase_if(waiting_, [](const auto& entry) { return entry.second.empty(); });
    return advanced;
}

}  // namespace romano::cluster
