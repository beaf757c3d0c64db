#include "overlay/cluster/ownership/settlement.h"

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

void Settlement::compare(const View& view) {
    next_compared_ = 0;
    compared_with_ = view.members;
}

/// A session that is begun meanwhile is looked at as it comes, whatever its number.
void Settlement::compare_some(const broker::BrokerCore& broker, const PeerLogs& logs) {
    if (!next_compared_) return;
    std::vector<const PeerLog*> others;
    for (const LogId& member : compared_with_) {
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
    const auto is_over = [&](const auto& conflict) {
        return !settle(effects, conflict->first, conflict->second, logs, membership, moving,
                       departures);
    };
    std::size_t looked = news_.size();
    for (const Conflict& news : std::exchange(news_, {})) {
        const auto conflict = conflicts_.find(news);
        if (conflict != conflicts_.end() && is_over(conflict)) conflicts_.erase(conflict);
    }
    if (looked == sessions_per_turn_) return;
    auto at = conflicts_.begin();
    if (looked_at_) {
        at = conflicts_.upper_bound(*looked_at_);
    } else if (effects.now < next_look_) {
        return;
    } else {
        next_look_ = effects.now + effects.times.conflicts_looked_at_every();
    }
    looked_at_.reset();
    while (at != conflicts_.end()) {
        const auto conflict = at++;
        if (++looked == sessions_per_turn_ && at != conflicts_.end()) looked_at_ = conflict->first;
        if (is_over(conflict)) conflicts_.erase(conflict);
        if (looked_at_) return;
    }
}

bool Settlement::settle(Effects& effects, const Conflict& conflict, broker::HybridTime& told,
                        const PeerLogs& logs, const Membership& membership, const HandBack& moving,
                        Departures& departures) const {
    const auto& [client, home] = conflict;
    const auto log = logs.find(home);
    if (log == logs.end() || log->second.is_frozen()) return false;
    const broker::SessionHeader* own = effects.broker.header(client);
    const broker::SessionHeader* theirs = log->second.mirror().header(client);
    if (own == nullptr || theirs == nullptr) return false;
    // An earlier life of its broker adopts nothing. Who does not hear us reads later what we wrote.
    if (moving.is_silent(own->via) || !membership.is_heard(home)) return true;
    if (gives_way(*own, log->second, *theirs)) {
        departures.move(effects, client, home, 0, logs);
        return false;
    }
    if (own->last_heard != told) {
        told = own->last_heard;
        effects.broker.append_header(client, effects.clients);
    }
    return true;
}

/// Where topic ids mean something else, neither copy goes on from the other; the one stays to which
/// the client spoke last.
bool Settlement::gives_way(const broker::SessionHeader& own, const PeerLog& other,
                           const broker::SessionHeader& theirs) const {
    const auto precedes = [&other](const auto& a, const auto& b) {
        return other.is_foreign() ? a.last_heard > b.last_heard : broker::outranks(a, b);
    };
    const BrokerId home = other.mirror().log().broker;
    return precedes(theirs, own) || (!precedes(own, theirs) && home > self_);
}

}  // namespace romano::cluster
