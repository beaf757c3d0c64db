#include "overlay/cluster/ownership/settlement.h"

#include <vector>

namespace romano::cluster {

void Settlement::on_peer_session(const Effects& effects, const LogId& peer,
                                 const broker::ClientId& client) {
    if (effects.broker.header(client) != nullptr) heed({client, peer});
}

void Settlement::heed(Conflict conflict) {
    conflicts_.try_emplace(conflict);
    if (news_.size() < sessions_per_turn_) news_.insert(std::move(conflict));
}

void Settlement::on_own_session(const broker::ClientId& client, const PeerLogs& logs) {
    for (const auto& [id, log] : logs) {
        const bool is_home = !log.is_frozen() && log.mirror().contains(client);
        if (is_home) heed({client, id});
    }
}

/// A session that is begun meanwhile is looked at as it comes, whatever its number.
void Settlement::compare_some(const broker::BrokerCore& broker, const PeerLogs& logs,
                              const View& view) {
    if (!next_compared_) return;
    std::vector<const PeerLog*> others;
    for (const LogId& member : view.members) {
        const auto log = logs.find(member);
        if (log != logs.end()) others.push_back(&log->second);
    }
    next_compared_ = broker.visit_client_ids(*next_compared_, compared_per_turn,
                                             [&](const broker::ClientId& client) {
                                                 for (const PeerLog* other : others) {
                                                     const broker::Mirror& theirs = other->mirror();
                                                     if (theirs.contains(client))
                                                         heed({client, theirs.log()});
                                                 }
                                             });
}

void Settlement::carry_on(Effects& effects, const PeerLogs& logs, const Membership& membership,
                          const HandBack& moving, Departures& departures) {
    std::size_t allowed = sessions_per_turn_;
    const auto is_over = [&](const auto& conflict) {
        const Outcome outcome = settle(effects, conflict->first, conflict->second, logs, membership,
                                       moving, departures);
        if (outcome == Outcome::gives_way) --allowed;
        return outcome != Outcome::lasts;
    };
    for (const Conflict& news : std::exchange(news_, {})) {
        const auto conflict = conflicts_.find(news);
        if (conflict != conflicts_.end() && is_over(conflict)) conflicts_.erase(conflict);
    }
    if (allowed == 0) return;
    auto at = conflicts_.begin();
    if (goes_on_at_) {
        at = conflicts_.lower_bound(*goes_on_at_);
    } else if (effects.now < next_look_) {
        return;
    } else {
        next_look_ = effects.now + effects.times.conflicts_looked_at_every();
    }
    goes_on_at_.reset();
    for (std::size_t looked = 0; at != conflicts_.end(); ++looked) {
        if (allowed == 0 || looked == compared_per_turn) {
            goes_on_at_ = at->first;
            return;
        }
        const auto conflict = at++;
        if (is_over(conflict)) conflicts_.erase(conflict);
    }
}

Settlement::Outcome Settlement::settle(Effects& effects, const Conflict& conflict,
                                       broker::HybridTime& told, const PeerLogs& logs,
                                       const Membership& membership, const HandBack& moving,
                                       Departures& departures) const {
    const auto& [client, home] = conflict;
    const auto log = logs.find(home);
    if (log == logs.end() || log->second.is_frozen()) return Outcome::is_over;
    const broker::SessionHeader* own = effects.broker.header(client);
    if (own == nullptr) return Outcome::is_over;
    const auto theirs = copy_in(log->second, client);
    if (!theirs) return Outcome::is_over;
    // An earlier life of its broker adopts nothing. Who does not hear us reads later what we wrote.
    if (moving.is_silent(own->via) || !membership.is_heard(theirs->home)) return Outcome::lasts;
    if (gives_way(*own, log->second, theirs->header, theirs->home.broker)) {
        departures.move(effects, client, theirs->home, 0, logs);
        return Outcome::gives_way;
    }
    if (own->last_heard != told) {
        told = own->last_heard;
        effects.broker.append_header(client, effects.clients);
    }
    return Outcome::lasts;
}

std::optional<LogId> Settlement::home_of_higher(broker::SessionHeader comes, const PeerLogs& logs,
                                                const Membership& membership) const {
    comes.provisional = true;  // as adopted
    for (const auto& [id, log] : logs) {
        if (log.is_frozen() || log.is_foreign()) continue;
        const auto theirs = copy_in(log, comes.client_id);
        if (!theirs || !membership.is_heard(theirs->home)) continue;
        if (gives_way(comes, log, theirs->header, theirs->home.broker)) return theirs->home;
    }
    return std::nullopt;
}

std::optional<Settlement::Copy> Settlement::copy_in(const PeerLog& log,
                                                    const broker::ClientId& client) const {
    if (const auto* theirs = log.mirror().header(client)) return Copy{*theirs, log.mirror().log()};
    const auto moved = log.moved().find(client);
    if (moved == log.moved().end() || moved->second.to.broker == self_) return std::nullopt;
    return Copy{moved->second.image.header, moved->second.to};
}

/// Where topic ids mean something else, neither copy goes on from the other; the one stays to which
/// the client spoke last.
bool Settlement::gives_way(const broker::SessionHeader& own, const PeerLog& other,
                           const broker::SessionHeader& theirs, BrokerId home) const {
    const auto precedes = [&other](const auto& a, const auto& b) {
        return other.is_foreign() ? a.last_heard > b.last_heard : broker::outranks(a, b);
    };
    return precedes(theirs, own) || (!precedes(own, theirs) && home > self_);
}

}  // namespace romano::cluster
