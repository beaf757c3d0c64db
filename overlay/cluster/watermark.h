// How far the own log is safe: held by `acks` peers of the view that are alive (design section 3,
// "Replication"). With fewer peers than that, by all of them; with none, everything is safe at
// once.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "broker/core/log_position.h"

namespace romano::cluster {

class Watermark {
public:
    explicit Watermark(std::uint32_t acks) : acks_(acks) {}

    void on_ack(const broker::LogId& peer, broker::Seq through) {
        broker::Seq& held = held_[peer];
        held = std::max(held, through);
    }
    void forget(const broker::LogId& peer) { held_.erase(peer); }
    void restart() {
        held_.clear();
        safe_ = 0;
    }

    /// Never falls: what was once shown to clients stays shown.
    broker::Seq advance(broker::Seq last, std::span<const broker::LogId> peers) {
        const std::size_t needed = std::min<std::size_t>(acks_, peers.size());
        broker::Seq reached = last;
        if (needed > 0) {
            std::vector<broker::Seq> held;
            held.reserve(peers.size());
            for (const auto& peer : peers) held.push_back(held_by(peer));
            const auto nth = held.begin() + static_cast<std::ptrdiff_t>(needed - 1);
            std::ranges::nth_element(held, nth, std::greater{});
            reached = std::min(*nth, last);
        }
        safe_ = std::max(safe_, reached);
        return safe_;
    }

    [[nodiscard]] broker::Seq safe() const { return safe_; }
    [[nodiscard]] broker::Seq held_by(const broker::LogId& peer) const {
        const auto found = held_.find(peer);
        return found == held_.end() ? 0 : found->second;
    }

private:
    std::uint32_t acks_;
    std::map<broker::LogId, broker::Seq> held_;
    broker::Seq safe_ = 0;
};

}  // namespace romano::cluster
