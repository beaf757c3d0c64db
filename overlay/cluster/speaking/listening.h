// A member that was away, paused or starved, listens to its peers and says nothing meanwhile.
//
// It may have been replaced, and a beacon that was sent early in that time cannot know it yet: so
// one that was sent late tells, by its tick. Whoever does not hear us is about to replace us,
// unless it has fallen silent since.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <variant>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/messages.h"
#include "romano/base/time.h"

namespace romano::cluster {

/// Who is in the view, and whose are addresses and sessions: not for a member that listens. What it
/// asks or answers may also have waited since before it was replaced. It comes again.
[[nodiscard]] inline bool asks_for_decision(const ClusterMessage& message) {
    return std::holds_alternative<ViewProposal>(message) ||
           std::holds_alternative<ViewHoldings>(message) ||
           std::holds_alternative<ViewAnnouncement>(message) ||
           std::holds_alternative<AddressOffer>(message) ||
           std::holds_alternative<AddressBound>(message) ||
           std::holds_alternative<SessionRequest>(message) ||
           std::holds_alternative<SessionClaim>(message);
}

class Listening {
public:
    /// Away again while it listens: what was late for the first time is late still.
    void begin(const Membership& membership, Duration away, Duration beacon_every) {
        const auto beacon_times_away = static_cast<std::uint64_t>(away / beacon_every);
        if (!std::exchange(is_on_, true)) {
            late_ticks_.clear();
            longest_away_ = {};
        }
        longest_away_ = std::max(longest_away_, away);
        has_heard_ = false;
        is_up_to_date_ = false;
        doubting_.clear();
        patience_ = membership.detection_time();
        for (const auto& [id, peer] : membership.peers()) {
            std::uint64_t& late = late_ticks_[peer.beacon.log];
            late = std::max(late, peer.beacon.tick + beacon_times_away * 3 / 4);
        }
    }
    void end() { is_on_ = false; }

    void on_beacon(Instant now, const LogId& self, const Beacon& beacon) {
        if (beacon.view.members.empty()) return;  // it knows no more than we do
        has_heard_ = true;
        if (beacon.view.contains(self) && !beacon.hears_from(self.broker)) {
            doubting_.insert_or_assign(beacon.log.broker, now);
        } else {
            doubting_.erase(beacon.log.broker);
        }
        const auto late = late_ticks_.find(beacon.log);
        if (late != late_ticks_.end() && beacon.tick >= late->second) is_up_to_date_ = true;
    }

    [[nodiscard]] bool is_on() const { return is_on_; }
    /// Since it listens, or when it did last.
    [[nodiscard]] Duration longest_away() const { return longest_away_; }
    /// A beacon came since the last call.
    bool take_heard() { return std::exchange(has_heard_, false); }
    /// A late one came.
    [[nodiscard]] bool is_up_to_date() const { return is_up_to_date_; }
    /// Somebody who is in one view with us takes us for dead: we are about to be replaced.
    [[nodiscard]] bool is_doubted(Instant now) const {
        return std::ranges::any_of(doubting_, [&](const auto& peer_and_said) {
            return now < peer_and_said.second + patience_;
        });
    }

private:
    bool is_on_ = false;
    Duration longest_away_{};
    bool has_heard_ = false;
    bool is_up_to_date_ = true;
    std::map<LogId, std::uint64_t> late_ticks_;  // of each peer: sent late in that time
    std::map<BrokerId, Instant> doubting_;       // and when they said so last
    Duration patience_{};
};

}  // namespace romano::cluster
