#include "firmware/robot/broker_choice.h"

#include <algorithm>

namespace romano::firmware {

void BrokerChoice::search(Instant now) {
    for (std::size_t i = candidates_.size(); i > 0; --i) {
        Candidate& candidate = candidates_[i - 1];
        if (!candidate.was_heard) {
            candidates_.erase_at(i - 1);
            continue;
        }
        candidate.was_heard = false;
        candidate.cost_when_searched = candidate.cost;
    }
    discovery_.search(now);
    search_at_ = now + search_again_every;
}

void BrokerChoice::abandon(Instant now, const Endpoint& broker) {
    for (std::size_t i = candidates_.size(); i > 0; --i) {
        if (candidates_[i - 1].broker == broker) candidates_.erase_at(i - 1);
    }
    search(now);
}

BrokerChoice::Candidate* BrokerChoice::find(const Endpoint& broker) {
    for (Candidate& candidate : candidates_) {
        if (candidate.broker == broker) return &candidate;
    }
    return nullptr;
}

/// In half milliseconds; much for who answers unasked.
std::int16_t BrokerChoice::answer_time(Instant now) const {
    using HalfMilliseconds = std::chrono::duration<std::int64_t, std::ratio<1, 2000>>;
    constexpr HalfMilliseconds most = std::chrono::seconds{5};
    if (asked_at_ == never) return most.count();
    const auto time = std::chrono::duration_cast<HalfMilliseconds>(now - asked_at_);
    return static_cast<std::int16_t>(std::min(time, most).count());
}

void BrokerChoice::on_datagram(Instant now, const Endpoint& from, Bytes datagram,
                               std::optional<int> link_dbm) {
    discovery_.on_datagram(now, from, datagram);
    for (const client::Gateway& gateway : discovery_.gateways()) {
        if (gateway.address != from) continue;
        const bool by_signal = link_dbm.has_value();
        const auto cost = by_signal ? static_cast<std::int16_t>(-*link_dbm) : answer_time(now);
        Candidate* known = find(from);
        if (known != nullptr) {
            // Of the times that answers took, the shortest is the way; the rest was waiting.
            known->cost = by_signal ? cost : std::min(known->cost, cost);
            known->was_heard = true;
            if (by_signal && cost >= known->cost_when_searched + weaker_db) {
                search_at_ = std::min(search_at_, now + looks_around_within);
            }
        } else {
            (void)candidates_.push_back({from, cost, cost, by_signal});
        }
        if (decides_at_ == never) decides_at_ = now + answers_within;
    }
}

std::size_t BrokerChoice::on_tick(Instant now, MutableBytes out) {
    if (search_at_ <= now) search(now);
    const std::size_t size = discovery_.on_tick(now, out);
    if (size != 0) {
        asked_at_ = now;
        decides_at_ = never;
    }
    return size;
}

Instant BrokerChoice::next_wakeup() const {
    return std::min(search_at_, discovery_.next_wakeup());
}

bool BrokerChoice::is_clearly_better(const Candidate& a, const Candidate& b) {
    if (a.by_signal != b.by_signal) return a.by_signal;
    return a.by_signal ? a.cost + clearly_better_db <= b.cost : 2 * a.cost + 4 <= b.cost;
}

std::optional<Endpoint> BrokerChoice::choose(Instant now,
                                             const std::optional<Endpoint>& current) const {
    if (candidates_.empty() || now < decides_at_) return current;
    Candidate best = candidates_[0];
    for (const Candidate& candidate : candidates_) {
        if (candidate.cost < best.cost) best = candidate;
    }
    if (!current) return best.broker;
    for (const Candidate& candidate : candidates_) {
        if (candidate.broker == *current) {
            return is_clearly_better(best, candidate) ? best.broker : *current;
        }
    }
    return current;  // it is served by somebody who does not tell of himself; all is well
}

}  // namespace romano::firmware
