#include "overlay/cluster/speaking/lease.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace romano::cluster {
namespace {

constexpr int most_terms_missed = 20;  // for whom we did not hear since a standstill
constexpr int terms_to_meet = 10;

}  // namespace

// A term is the detection timeout: who misses a member waits for its lease a beacon time longer at
// most, for detectors count beacons. Two beacon times are the age of an echo without loss; what is
// left of the holder's term is for processes that wait for a processor.
//
// A time daemon slews a clock by a twelfth at most, and two clocks may be slewed apart: then what
// the holder takes for a term is 15.4 % of one longer than what the others wait. A fifth of a term
// leaves the rest for what leaves late.
Lease::Lease(const LogId& self, Duration beacon_every, Duration detection_timeout)
    : self_(self),
      beacon_every_(beacon_every),
      term_(std::max(detection_timeout, 3 * beacon_every)),
      margin_(term_ / 5) {}

// --- the own lease

void Lease::on_beat(Instant now, std::uint64_t tick) {
    (void)notice_standstill(now);
    acted_at_ = now;
    beats_.push_back({tick, now});
    while (now >= beats_.front().stamped_at + 3 * term_) beats_.pop_front();
}

std::optional<Duration> Lease::notice_standstill(Instant now) {
    if (acted_at_ == never || now < acted_at_ + term_) return std::nullopt;
    const Duration away = now - std::exchange(acted_at_, now);
    missed_until_ = std::max(missed_until_, now + std::min(away, most_terms_missed * term_));
    const auto beats_away = static_cast<std::uint64_t>(away / beacon_every_);
    for (auto& [peer, heard] : heard_) {
        heard.late_tick = std::max(heard.late_tick, heard.tick + beats_away * 3 / 4);
    }
    return away;
}

void Lease::on_echo(const LogId& by, std::uint64_t tick, const ViewNumber& installed,
                    const std::vector<BrokerId>& vouched) {
    const auto beat = std::ranges::lower_bound(beats_, tick, {}, &Beat::tick);
    if (beat == beats_.end() || beat->tick != tick) return;
    if (installed <= view_.number) return take(by, beat->stamped_at, vouched);
    if (ahead_.size() < heard_most) {
        ahead_.insert_or_assign(by, {installed, beat->stamped_at, vouched});
    }
}

void Lease::take(const LogId& by, Instant stamped_at, const std::vector<BrokerId>& vouched) {
    if (!view_.contains(by)) return;
    Echoed& newest = echoed_[by];
    if (stamped_at < newest.stamped_at) return;
    newest.stamped_at = stamped_at;
    newest.vouched = vouched;
}

bool Lease::is_held(Instant now) const {
    if (now >= held_until_) held_until_ = ends_at();
    return now < held_until_;
}

Instant Lease::stamped_at(const LogId& echoed_by) const {
    const auto echo = echoed_.find(echoed_by);
    return echo == echoed_.end() ? Instant::min() : echo->second.stamped_at;
}

Instant Lease::ends_at() const {
    if (view_.members.empty() || promised_.size() > promises_most) return Instant::min();
    Instant end = majority_ends_at(view_.members);
    for (const View& promised : promised_) end = std::min(end, majority_ends_at(promised.members));
    for (const LogId& member : view_.members) {
        if (member != self_ && own_word_ends_at(member) < end) {
            end = std::min(end, word_ends_at(member));
        }
    }
    return end;
}

Instant Lease::own_word_ends_at(const LogId& member) const {
    const Instant stamp = stamped_at(member);
    return stamp == Instant::min() ? stamp : stamp + 3 * (term_ - margin_);
}

/// Until then that member makes no view with less than half of ours. It echoed our tick, or, a term
/// before ours at the soonest, that of a third one.
Instant Lease::word_ends_at(const LogId& member) const {
    Instant end = own_word_ends_at(member);
    // Until it is heard itself what it serves is not known: it is given time for that.
    const Instant met_at =
        end == Instant::min() ? members_since_.at(member) + terms_to_meet * term_ : Instant::min();
    for (const auto& [third, echo] : echoed_) {
        if (std::ranges::count(echo.vouched, member.broker) == 0) continue;
        if (echo.stamped_at < met_at) continue;
        end = std::max(end, echo.stamped_at + 2 * (term_ - margin_));
    }
    return end;
}

/// More than half of them, this broker included, vouch for it until then.
Instant Lease::majority_ends_at(const std::vector<LogId>& members) const {
    const std::size_t others_needed = members.size() / 2;
    if (others_needed == 0) return Instant::max();
    std::vector<Instant> stamps;
    stamps.reserve(members.size());
    for (const LogId& member : members) {
        if (member != self_) stamps.push_back(stamped_at(member));
    }
    const auto decisive = stamps.begin() + static_cast<std::ptrdiff_t>(others_needed - 1);
    std::ranges::nth_element(stamps, decisive, std::greater{});
    return *decisive == Instant::min() ? *decisive : *decisive + term_ - margin_;
}

// --- the leases of others

void Lease::on_heard(Instant now, const LogId& peer, std::uint64_t tick) {
    if (heard_.size() >= heard_most && !heard_.contains(peer)) {
        erase_if(heard_, [this](const auto& entry) { return !view_.contains(entry.first); });
    }
    Heard& heard = heard_[peer];
    if (tick > heard.tick) heard = {tick, now, heard.late_tick};
}

bool Lease::may_be_outdated(const LogId& peer) const {
    const auto heard = heard_.find(peer);
    return heard != heard_.end() && heard->second.tick < heard->second.late_tick;
}

std::vector<Echo> Lease::echoes() const {
    std::vector<Echo> all;
    all.reserve(view_.members.size());
    for (const LogId& member : view_.members) {
        const auto heard = heard_.find(member);
        if (member == self_ || heard == heard_.end() || refused_.contains(member)) continue;
        all.push_back({member, heard->second.tick});
    }
    return all;
}

std::vector<BrokerId> Lease::vouched(Instant now) const {
    std::vector<BrokerId> all;
    all.reserve(echoed_.size());
    for (const auto& [by, echo] : echoed_) {
        if (now < echo.stamped_at + term_ - margin_) all.push_back(by.broker);
    }
    return all;
}

/// When the last tick of that member was heard that we echoed.
Instant Lease::echoed_heard_at(const LogId& peer) const {
    if (const auto refusal = refused_.find(peer); refusal != refused_.end()) {
        return refusal->second.heard_at;
    }
    const auto heard = heard_.find(peer);
    return heard == heard_.end() ? Instant::min() : heard->second.at;
}

void Lease::want(const View* wanted) {
    erase_if(refused_, [&](const auto& entry) {
        const auto& [member, refusal] = entry;
        return !refusal.is_promised && (wanted == nullptr || wanted->contains(member));
    });
    if (wanted == nullptr) return;
    for (const LogId& member : view_.members) {
        if (wanted->contains(member)) continue;
        refused_.try_emplace(member, Refusal{echoed_heard_at(member)});
    }
}

Instant Lease::is_over_at(const View& next, const HasEnded& has_ended) const {
    const Duration wait = keeps_less_than_half(next) ? 3 * term_ : term_;
    Instant over = Instant::min();
    for (const LogId& member : view_.members) {
        if (member == self_ || next.contains(member)) continue;
        if (may_be_outdated(member)) over = std::max(over, missed_until_);
        if (has_ended(member)) continue;
        const Instant heard_at = echoed_heard_at(member);
        if (heard_at != Instant::min()) over = std::max(over, heard_at + wait);
    }
    return over;
}

/// Then it may share no member with the majority that still vouches for one that it leaves out. Two
/// members hold one lease only: both vouch.
bool Lease::keeps_less_than_half(const View& next) const {
    const auto is_less = [&](const View& view) {
        const auto kept = std::ranges::count_if(
            view.members, [&](const LogId& member) { return next.contains(member); });
        return 2 * static_cast<std::size_t>(kept) < view.members.size();
    };
    return (view_.members.size() != 2 && is_less(view_)) || std::ranges::any_of(promised_, is_less);
}

// --- views

void Lease::on_promise(const View& promised) {
    for (const LogId& member : view_.members) {
        if (promised.contains(member)) continue;
        refused_.try_emplace(member, Refusal{echoed_heard_at(member)}).first->second.is_promised =
            true;
    }
    const bool is_known = std::ranges::count(promised_, promised.members, &View::members) > 0;
    if (!is_known && promised_.size() <= promises_most) promised_.push_back(promised);
    held_until_ = Instant::min();
}

/// From here on all members of the view are echoed (model: echo_again).
void Lease::on_view(Instant now, const View& installed) {
    was_held_before_ = is_held(now);
    view_ = installed;
    erase_if(members_since_, [this](const auto& entry) { return !view_.contains(entry.first); });
    for (const LogId& member : view_.members) members_since_.try_emplace(member, now);
    promised_.clear();
    refused_.clear();
    erase_if(echoed_, [this](const auto& echo) { return !view_.contains(echo.first); });
    erase_if(ahead_, [this](const auto& entry) {
        const auto& [by, echo] = entry;
        if (echo.installed > view_.number) return false;
        take(by, echo.stamped_at, echo.vouched);
        return true;
    });
    held_until_ = Instant::min();
}

void Lease::restart(const LogId& self) {
    self_ = self;
    view_ = {};
    promised_.clear();
    members_since_.clear();
    echoed_.clear();
    ahead_.clear();
    refused_.clear();
    held_until_ = Instant::min();
}

}  // namespace romano::cluster
