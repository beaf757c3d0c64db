// How far the own log is safe: held by `acks` peers of the view that are alive. With fewer peers
// than that, by all of them; with none, everything is safe at once.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "broker/core/log_position.h"
#include "romano/base/flat_map.h"

namespace romano::cluster {

class Watermark {
public:
    explicit Watermark(std::uint32_t acks) : acks_(acks) {}

    void on_ack(const broker::LogId& peer, broker::Seq through) {
        hold(peer, std::max(held_by(peer), through));
    }
    /// The peer's beacon tells all that it holds: less than it once had, when it let our log go
    /// while we were out of its sight.
    void on_beacon(const broker::LogId& peer, broker::Seq holds) { hold(peer, holds); }
    void forget(const broker::LogId& peer) {
        held_.erase(peer);
        is_news_ = true;
    }

    /// Never falls: what was once shown to clients stays shown.
    /// `among`: another number when these are other peers than the last time.
    broker::Seq advance(broker::Seq last, std::span<const broker::LogId> peers,
                        std::uint64_t among) {
        const bool is_news = std::exchange(is_news_, false) || last != last_ || among != among_;
        if (!is_news) return safe_;
        last_ = last;
        among_ = among;
        if (safe_ >= last) return safe_;
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
    /// Clients were told of something that no peer ever held.
    [[nodiscard]] bool has_promised_alone() const { return safe_ > most_held_; }
    [[nodiscard]] broker::Seq held_by(const broker::LogId& peer) const {
        const auto found = held_.find(peer);
        return found == held_.end() ? 0 : found->second;
    }

private:
    void hold(const broker::LogId& peer, broker::Seq through) {
        const broker::Seq before = std::exchange(held_[peer], through);
        is_news_ |= before != through;
        most_held_ = std::max(most_held_, through);
    }

    std::uint32_t acks_;
    FlatMap<broker::LogId, broker::Seq> held_;
    broker::Seq most_held_ = 0;
    broker::Seq safe_ = 0;
    broker::Seq last_ = 0;     // as of the last advance()
    std::uint64_t among_ = 0;  // as well
    bool is_news_ = true;      // since then
};

}  // namespace romano::cluster
