#include "overlay/sim/invariants.h"

#include <algorithm>
#include <chrono>

#include "overlay/sim/trace.h"

namespace romano::sim {

namespace {

bool have_a_common_member(const cluster::View& a, const cluster::View& b) {
    return std::ranges::any_of(a.members, [&](const auto& log) { return b.contains(log); });
}

std::string text_of(const cluster::ViewNumber& number) {
    return std::to_string(number.term) + "." + std::to_string(number.count);
}

/// The same, but for positions that one of them does not know, and those in the log that says it:
/// no publish stands between the image and the event.
bool is_as_left(SessionBetween copy, SessionBetween left) {
    const auto leave_out = [&](auto& positions, const auto& others) {
        std::erase_if(positions, [&](const broker::LogPosition& position) {
            return position.log == left.moved.log ||
                   std::ranges::count(others, position.log, &broker::LogPosition::log) == 0;
        });
    };
    leave_out(copy.image.worked_through, left.image.worked_through);
    leave_out(left.image.worked_through, copy.image.worked_through);
    return copy.image.header == left.image.header && broker::same_state(copy.image, left.image);
}

}  // namespace

std::vector<Invariant> Invariants::judge(Instant now, std::span<const Sight> brokers,
                                         std::size_t acting) {
    const Sight& broker = brokers[acting];
    now_ = now;
    one_speaker(brokers, broker);
    agreed_end(brokers, broker);
    shown_is_held(brokers, broker);
    never_back(broker);
    one_owner(broker);
    as_at_the_seal(brokers, broker);
    named_first(broker);
    one_shard(brokers, broker);
    one_copy(broker);
    bounded(brokers, broker);
    return std::exchange(new_, {});
}

bool Invariants::is_broken(Invariant invariant) const {
    return !breaches_[static_cast<std::size_t>(invariant)].empty();
}

void Invariants::report(Invariant invariant, const std::string& what) {
    std::string& breach = breaches_[static_cast<std::size_t>(invariant)];
    if (!breach.empty()) return;
    const auto at = std::chrono::duration_cast<std::chrono::microseconds>(now_.time_since_epoch());
    breach = "at " + std::to_string(at.count()) + " us " + what;
    new_.push_back(invariant);
}

/// I1: two brokers that may send from one address at one moment, or of which one does, are in views
/// without a common member.
void Invariants::one_speaker(std::span<const Sight> brokers, const Sight& broker) {
    if (is_broken(Invariant::one_speaker)) return;
    std::set<Endpoint> speaks_from = broker.said_from;
    if (broker.is_speaking) {
        speaks_from.insert(broker.speaks_from.begin(), broker.speaks_from.end());
    }
    for (const Sight& other : brokers) {
        if (other.log == broker.log || !other.is_speaking) continue;
        if (!have_a_common_member(broker.view, other.view)) continue;
        for (const Endpoint& address : speaks_from) {
            if (std::ranges::count(other.speaks_from, address) == 0) continue;
            report(Invariant::one_speaker, broker.name + ", in view " +
                                               text_of(broker.view.number) + ", and " + other.name +
                                               ", in " + text_of(other.view.number) +
                                               ", may both speak from " + to_text(address));
        }
    }
}

/// I2: all say the same of where a view ended a removed log, and nobody takes more of it then. One
/// writer makes a log, and it is applied in order: whoever has come as far holds the same events.
void Invariants::agreed_end(std::span<const Sight> brokers, const Sight& broker) {
    for (const LogCopy& copy : broker.copies) {
        const HolderAndLog mine{broker.log, copy.log};
        if (!copy.end) {
            taken_.erase(mine);
            continue;
        }
        const auto [known, is_new] = ends_.try_emplace({copy.end->in, copy.log}, copy.end->seq);
        if (is_new) safe_is_safe(brokers, broker, copy);
        if (known->second != copy.end->seq) {
            report(Invariant::agreed_end, broker.name + " ends a log at " +
                                              std::to_string(copy.end->seq) + ", others at " +
                                              std::to_string(known->second));
        }
        const auto [taken, is_first] = taken_.try_emplace(mine, Taken{copy.end->in, copy.applied});
        const broker::Seq most = std::max(copy.end->seq, taken->second.applied);
        if (!is_first && taken->second.ended_in == copy.end->in && copy.applied > most) {
            report(Invariant::agreed_end, broker.name + " takes a log up to " +
                                              std::to_string(copy.applied) + " that ended at " +
                                              std::to_string(copy.end->seq));
        }
        taken->second = {copy.end->in, copy.applied};
    }
}

/// I3: what a client may have been shown, and a member of the view holds, lies within the end that
/// the view agreed on.
void Invariants::safe_is_safe(std::span<const Sight> brokers, const Sight& broker,
                              const LogCopy& ended) {
    const auto shown = shown_.find(ended.log);
    if (shown == shown_.end() || broker.view.number != ended.end->in) return;
    for (const Sight& member : brokers) {
        const LogCopy* copy = member.copy_of(ended.log);
        if (copy == nullptr || !broker.view.contains(member.log)) continue;
        const broker::Seq known = std::min(shown->second, copy->applied);
        if (known <= ended.end->seq) continue;
        report(Invariant::safe_is_safe,
               "a log ended at " + std::to_string(ended.end->seq) + ", but " + member.name +
                   " holds it, and its clients know it, up to " + std::to_string(known));
    }
}

/// I3, too: `acks` peers hold what a client may have been shown, or held it when they died.
void Invariants::shown_is_held(std::span<const Sight> brokers, const Sight& broker) {
    for (const LogCopy& copy : broker.copies) {
        broker::Seq& most = held_[{broker.log.broker, copy.log}];
        most = std::max(most, copy.acknowledged);
    }
    broker::Seq& shown = shown_[broker.log];
    if (broker.shown <= shown) return;
    shown = broker.shown;
    const auto holders = std::ranges::count_if(brokers, [&](const Sight& other) {
        const auto held = held_.find({other.log.broker, broker.log});
        return held != held_.end() && held->second >= shown;
    });
    if (static_cast<std::size_t>(holders) >= broker.holders) return;
    report(Invariant::safe_is_safe, broker.name + " shows its log up to " + std::to_string(shown) +
                                        ", and " + std::to_string(holders) + " of " +
                                        std::to_string(broker.holders) + " peers hold it");
}

/// I4: in one life of a broker the numbers of its view and of what it promised never fall.
void Invariants::never_back(const Sight& broker) {
    const Numbers now{broker.view.number, broker.promised};
    Numbers& before = numbers_.try_emplace(broker.log, now).first->second;
    if (now.view < before.view) {
        report(Invariant::never_back, broker.name + " goes from view " + text_of(before.view) +
                                          " back to " + text_of(now.view));
    }
    if (now.promised < before.promised) {
        report(Invariant::never_back, broker.name + " promised " + text_of(before.promised) +
                                          ", and takes it back to " + text_of(now.promised));
    }
    before = now;
}

/// I5: while a view lasts, an address goes from one speaker to another only when the first has
/// sealed it for the other.
void Invariants::one_owner(const Sight& broker) {
    if (is_broken(Invariant::one_owner)) return;
    for (const broker::Sealed& seal : broker.sealed) {
        seals_.insert_or_assign({broker.log, seal.address}, seal.to);
    }
    if (!broker.is_speaking) return;
    for (const Endpoint& address : broker.speaks_from) {
        const auto owner = owners_.try_emplace({broker.view.number, address}, broker.log).first;
        const auto seal = seals_.find({owner->second, address});
        const bool is_sealed = seal != seals_.end() && seal->second == broker.log;
        // Another life of the same broker is in another view of that number.
        if (is_sealed || owner->second.broker == broker.log.broker) {
            owner->second = broker.log;
            continue;
        }
        report(Invariant::one_owner, broker.name + " speaks from " + to_text(address) +
                                         ", as another broker did, in view " +
                                         text_of(broker.view.number));
    }
}

/// I5: whoever adopts a session that another broker moved goes on from what that one left.
void Invariants::as_at_the_seal(std::span<const Sight> brokers, const Sight& broker) {
    for (const SessionBetween& copy : broker.mirrored) {
        for (const Sight& home : brokers) {
            const auto left = std::ranges::find(home.leaving, copy.moved, &SessionBetween::moved);
            if (left == home.leaving.end()) continue;
            if (is_as_left(copy, *left)) continue;
            report(Invariant::as_at_the_seal, broker.name + " would adopt another state of " +
                                                  copy.image.header.client_id + " than " +
                                                  home.name + " left");
        }
    }
}

/// I6: no member of a view acknowledges that a home routes a message before it holds that message.
/// Of others no acknowledgement counts.
void Invariants::named_first(const Sight& broker) {
    if (!broker.view.contains(broker.log)) return;
    for (const Reference& reference : broker.references) {
        if (reference.to.log == broker.log || reference.to.log == reference.by) continue;
        if (reference.is_held) continue;
        report(Invariant::named_first,
               broker.name + " acknowledges what tells of a message that it lacks");
    }
}

/// I7: of two brokers in one view no more than one may speak to a client.
///
/// Two sides of a cut both serve a client (availability comes first), and when they meet neither
/// knows of the other one's copy before it has read the other one's log. What a member says comes
/// within a detection time, or it is not heard any more: so long after they met both may speak.
/// Two members of whom one does not hear the other, in a view that a third one holds together, may
/// as well: who does not hear learns nothing, as no third one passes logs on. But whoever has read
/// of a copy that outranks its own gives way at once; where more are settled than fit a turn, at
/// the next look at all of them.
void Invariants::one_shard(std::span<const Sight> brokers, const Sight& broker) {
    note_higher_copies(broker);
    for (const Sight& other : brokers) {
        if (other.log == broker.log) continue;
        const bool have_met_long_ago = have_met(broker, other);
        if (!broker.is_speaking || !other.is_speaking) continue;
        if (other.view.number != broker.view.number) continue;
        for (const std::string& client : broker.speaks_to) {
            if (std::ranges::count(other.speaks_to, client) == 0) continue;
            if (!have_met_long_ago && !must_give_way(broker, {client, other.log}) &&
                !must_give_way(other, {client, broker.log})) {
                continue;
            }
            report(Invariant::one_shard,
                   client + " is spoken to by " + broker.name + " and by " + other.name);
        }
    }
}

/// A detection time ago or longer: each is in the other's view, and hears it, since then.
bool Invariants::have_met(const Sight& one, const Sight& other) {
    const std::pair<broker::LogId, broker::LogId> both = std::minmax(one.log, other.log);
    if (!one.view.contains(other.log) || std::ranges::count(one.hears, other.log) == 0 ||
        !other.view.contains(one.log) || std::ranges::count(other.hears, one.log) == 0) {
        met_.erase(both);
        return false;
    }
    const Instant since = met_.try_emplace(both, now_).first->second;
    return now_ >= since + std::max(one.times.detection, other.times.detection);
}

void Invariants::note_higher_copies(const Sight& broker) {
    auto& known = higher_[broker.log];
    std::erase_if(known, [&](const auto& entry) {
        return !broker.is_speaking || std::ranges::count(broker.higher, entry.first) == 0;
    });
    if (!broker.is_speaking) return;
    for (const HigherCopy& copy : broker.higher) {
        const auto is_it = [&](const auto& entry) { return entry.first == copy; };
        if (std::ranges::none_of(known, is_it)) known.emplace_back(copy, now_);
    }
}

bool Invariants::must_give_way(const Sight& broker, const HigherCopy& to) const {
    const auto known = higher_.find(broker.log);
    return known != higher_.end() && std::ranges::any_of(known->second, [&](const auto& entry) {
               return entry.first == to &&
                      now_ > entry.second + broker.times.conflicts_looked_at_every();
           });
}

/// I7: a broker has one copy of a session, its own or one on its way to another home.
void Invariants::one_copy(const Sight& broker) {
    for (const std::string& client : broker.twice) {
        report(Invariant::one_copy,
               broker.name + " has a session of " + client + ", and another one that leaves");
    }
}

/// I8, of what can be told from outside: the logs that a broker keeps, and the events of its own.
void Invariants::bounded(std::span<const Sight> brokers, const Sight& broker) {
    constexpr std::size_t lives_each = 16;  // that one broker may have begun while logs are kept
    if (broker.copies.size() > lives_each * brokers.size()) {
        report(Invariant::bounded,
               broker.name + " keeps " + std::to_string(broker.copies.size()) + " logs");
    }
    if (broker.own_events > events_most_) {
        report(Invariant::bounded,
               broker.name + " keeps " + std::to_string(broker.own_events) + " events of its log");
    }
}

}  // namespace romano::sim
