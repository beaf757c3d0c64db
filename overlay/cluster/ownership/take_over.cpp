#include "overlay/cluster/ownership/take_over.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace romano::cluster {
namespace {

constexpr std::size_t listed_per_turn = 1'000;  // about a millisecond

/// It was removed, and yet we hear it: not everybody does. Beside it we would be silent
/// (hand_back.h), and call its clients away from where they are answered.
bool is_still_serving(const Assignment& assignment, const Membership& membership) {
    const LogId& log = assignment.end.log;
    return membership.is_heard(log) && membership.find(log.broker)->is_serving(assignment.address);
}

/// The dead broker had handed the session over, and died before its log said so; or its log is
/// outdated here, and another broker went on with the session. Not so when that one is dead, too,
/// and nobody handed it anything: it may be the one from whose log this one had the session.
bool is_elsewhere(const broker::SessionHeader& left, const PeerLog& log, const Effects& effects,
                  const PeerLogs& logs) {
    if (log.is_outdated() && effects.broker.header(left.client_id) != nullptr) return true;
    return std::ranges::any_of(logs, [&](const auto& entry) {
        const broker::SessionHeader* other = entry.second.session(left.client_id);
        if (other == nullptr) return false;
        if (log.is_outdated()) return true;
        return entry.second.is_frozen() ? other->epoch > left.epoch
                                        : broker::outranks(*other, left);
    });
}

}  // namespace

void TakeOver::on_view(Instant now, const ViewAnnouncement& announcement,
                       const ServiceAddresses& addresses) {
    // What was assigned by an earlier view and is not done is assigned anew by this one. What is
    // half done is ours, unless it is another one's now.
    const auto is_same = [](const Assignment& a, const Assignment& b) {
        return a.end.log == b.end.log && a.address == b.address;
    };
    std::erase_if(pending_, [&](const Pending& pending) {
        return !pending.is_begun ||
               std::ranges::any_of(announcement.assignments, [&](const Assignment& assignment) {
                   return is_same(assignment, pending.assignment) && assignment.heir != self_;
               });
    });
    others_.clear();
    const auto is_gone = [&announcement](BrokerId heir) {
        return std::ranges::count(announcement.view.members, heir, &LogId::broker) == 0;
    };
    for (auto& [address, awaited] : awaited_heirs_) std::erase_if(awaited.heirs, is_gone);
    std::erase_if(left_to_, [&](const auto& entry) { return is_gone(entry.second.heir); });
    std::set<Endpoint> named{Endpoint{}};  // what was left at no address is each heir's
    std::set<Endpoint> taken;              // that nobody spoke from until now
    for (const Assignment& assignment : announcement.assignments) {
        const bool is_first = named.insert(assignment.address).second;
        if (assignment.heir != self_) {
            if (is_first) {
                others_.insert(assignment.address);
                left_to_.insert_or_assign(assignment.address, FirstHeir{assignment.heir, now});
            }
            if (taken.contains(assignment.address)) {
                AwaitedHeirs& awaited = awaited_heirs_[assignment.address];
                awaited.heirs.insert(assignment.heir);
                awaited.since = now;
            }
            continue;
        }
        if (is_first) left_to_.erase(assignment.address);
        if (is_first && !addresses.is_claimed(assignment.address)) {
            taken.insert(assignment.address);
        }
        const bool is_begun = std::ranges::any_of(pending_, [&](const Pending& pending) {
            return is_same(assignment, pending.assignment);
        });
        if (!is_begun) pending_.push_back({assignment, now});
    }
}

void TakeOver::carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                        const View& view, ServiceAddresses& addresses, Departures& departures,
                        bool may_begin) {
    std::erase_if(awaited_heirs_, [&effects](const auto& entry) {
        const AwaitedHeirs& awaited = entry.second;
        return awaited.heirs.empty() ||
               effects.now > awaited.since + effects.times.other_heirs_waited_for();
    });
    std::erase_if(left_to_, [&effects](const auto& entry) {
        return effects.now > entry.second.since + effects.times.other_heirs_waited_for();
    });
    const bool may_go_on = std::exchange(may_go_on_, false);
    std::vector<broker::ClientId> awaited;
    if (may_go_on) awaited = awaited_.take(sessions_per_turn_);
    std::erase_if(pending_, [&](Pending& pending) {
        const Endpoint& address = pending.assignment.address;
        const auto log = logs.peers.find(pending.assignment.end.log);
        if (log == logs.peers.end()) return true;
        if (!log->second.is_frozen()) return true;  // it is back
        const bool are_known = log->second.call_back(view, logs.peers);
        if (pending.is_begun) {
            return may_go_on &&
                   adopt_some(effects, pending, log->second, logs, awaited, departures);
        }
        if (!may_begin) return false;
        const bool is_ours = addresses.is_claimed(address);
        // It was done already, and the leader had not heard of it.
        if (are_known && is_ours && log->second.clients_left(address).empty()) return true;
        if (is_still_serving(pending.assignment, membership)) return false;
        if (log->second.is_foreign()) return true;  // its leader is of a version that knows no such
        if (log->second.is_outdated() && !holds_all(logs, membership, view)) return false;
        // What comes here is not passed on: it would be sealed, and then spoken from. Else it goes
        // to the member that is there already: the address's own broker, when that is back, or an
        // heir that an earlier life of it left the address to.
        const auto owner =
            is_ours ? std::nullopt : membership.server_of(address, view, [&](const Peer& peer) {
                return peer.is_serving(address);
            });
        if (!is_ours && !owner && others_.contains(address) &&
            effects.now <= pending.since + effects.times.giver_waited_for()) {
            return false;
        }
        if (owner) {
            const Peer& server = *membership.find(owner->broker);
            const LogPosition end{logs.own.id(), effects.broker.last_seq()};
            if (!server.beacon.hears_from(self_) || !server.follows(end)) return false;
        }
        if ((!are_known || !is_complete(effects, log->second, logs, owner.has_value())) &&
            !is_out_of_patience(effects, pending)) {
            return false;
        }
        pending.is_begun = true;
        pending.server = owner;
        pending.clients = log->second.clients_left(address);
        if (owner) {
            log->second.mark_served(address);
        } else {
            begin(effects, pending, log->second, membership, addresses);
        }
        const bool are_many = pending.clients.size() > sessions_per_turn_;  // to find was enough
        if (!are_many) return adopt_some(effects, pending, log->second, logs, {}, departures);
        if (const auto first = log->second.session_left(pending.clients.front())) {
            for (const auto& message : missed_publishes(*first, effects.broker, logs)) {
                awaited_.on_publish(message->topic);
            }
        }
        return false;
    });
    if (may_go_on && std::ranges::none_of(pending_, &Pending::is_begun)) awaited_.clear();
}

/// All that the members say in this view: where their clients are, those that they have just taken
/// over among them.
bool TakeOver::holds_all(const Logs& logs, const Membership& membership, const View& view) const {
    std::set<Endpoint> served;
    for (const LogId& member : view.members) {
        if (member.broker == self_) continue;
        const Peer* peer = membership.find(member.broker);
        const auto log = logs.peers.find(member);
        if (peer == nullptr || log == logs.peers.end() || peer->beacon.log != member ||
            peer->beacon.view.number != view.number ||
            log->second.applied() < peer->beacon.last_seq) {
            return false;
        }
        served.insert(peer->beacon.serving.begin(), peer->beacon.serving.end());
    }
    return std::ranges::includes(served, others_);
}

/// The dead broker's log is here. What another broker is to go on from must have all publishes of
/// all logs that are removed: it may hold nothing of them.
bool TakeOver::is_complete(const Effects& effects, const PeerLog& dead, const Logs& logs,
                           bool for_another) {
    if (!dead.has_agreed_end()) return false;
    return !for_another || std::ranges::all_of(logs.peers, [&](const auto& entry) {
        const auto& [id, log] = entry;
        return log.has_agreed_end() || log.reaches_agreed_end(effects.broker.cursor(id));
    });
}

bool TakeOver::awaits(const LogId& log) const {
    return std::ranges::any_of(pending_, [&log](const Pending& pending) {
        return !pending.is_begun && pending.assignment.end.log == log;
    });
}

bool TakeOver::is_out_of_patience(Effects& effects, const Pending& pending) const {
    if (effects.now <= pending.since + effects.times.tail_waited_for()) return false;
    effects.local.push_back(Notice{"takes over without the last events of a removed broker"});
    return true;
}

void TakeOver::begin(Effects& effects, Pending& pending, PeerLog& log, const Membership& membership,
                     ServiceAddresses& addresses) {
    const Assignment& assignment = pending.assignment;
    effects.local.push_back(Notice{"adopts " + std::to_string(pending.clients.size()) +
                                   " sessions of " +
                                   membership.name_of(assignment.end.log.broker)});
    if (assignment.address.family == Endpoint::Family::none) return;
    addresses.on_adopted(assignment.address);
    if (others_.contains(assignment.address)) return;
    addresses.inherit(effects, assignment.address);
    ++inherited_;
    log.mark_served(assignment.address);
}

bool TakeOver::list_some(Pending& pending, const PeerLog& log) {
    const std::size_t end = std::min(pending.listed + listed_per_turn, pending.clients.size());
    const bool are_any = pending.listed < end;
    for (; pending.listed < end; ++pending.listed) {
        const auto* session = log.mirror().session(pending.clients[pending.listed]);
        if (session != nullptr) awaited_.list(*session);
    }
    return are_any;
}

bool TakeOver::adopt_some(Effects& effects, Pending& pending, PeerLog& log, const Logs& logs,
                          const std::vector<broker::ClientId>& awaited, Departures& departures) {
    const Endpoint& address = pending.assignment.address;
    for (const auto& client : awaited) {
        adopt_one(effects, pending, log, logs, client, departures);
    }
    const bool are_many = pending.clients.size() > sessions_per_turn_;
    if (are_many && list_some(pending, log)) return false;
    const bool are_any = pending.looked_at < pending.clients.size();
    const std::size_t end =
        std::min(pending.looked_at + sessions_per_turn_ - awaited.size(), pending.clients.size());
    for (; pending.looked_at < end; ++pending.looked_at) {
        adopt_one(effects, pending, log, logs, pending.clients[pending.looked_at], departures);
    }
    if (pending.looked_at < pending.clients.size()) return false;
    if (are_many) {
        if (are_any) return false;                    // to find what is left takes a turn, too
        pending.clients = log.clients_left(address);  // a tail may have brought more meanwhile
        pending.looked_at = pending.listed = 0;
        if (!pending.clients.empty()) return false;
    }
    if (pending.server) effects.broker.seal(address, *pending.server, effects.clients);
    return true;
}

void TakeOver::adopt_one(Effects& effects, const Pending& pending, PeerLog& log, const Logs& logs,
                         const broker::ClientId& client, Departures& departures) const {
    auto image = log.session_left(client);
    if (!image || image->header.via != pending.assignment.address) return;
    if (!is_elsewhere(image->header, log, effects, logs.peers)) {
        // One that is here already is joined with it, and goes from here.
        if (pending.server && effects.broker.header(client) == nullptr) {
            departures.pass_on(effects, logs, *std::move(image), *pending.server);
        } else {
            departures.adopt(effects, logs, *std::move(image));
        }
    }
    log.mark_taken(client);
}

void TakeOver::on_handed_over(BrokerId from, const Endpoint& address) {
    const auto awaited = awaited_heirs_.find(address);
    if (awaited != awaited_heirs_.end()) awaited->second.heirs.erase(from);
}

void TakeOver::on_publish(std::string_view topic) {
    if (std::ranges::any_of(pending_, &Pending::is_begun)) awaited_.on_publish(topic);
}

bool TakeOver::is_half_adopted(const Endpoint& address) const {
    return std::ranges::any_of(pending_, [&](const Pending& pending) {
        return pending.is_begun && pending.assignment.address == address;
    });
}

bool TakeOver::may_rest() const {
    const auto is_begun_and_listed = [](const Pending& pending) {
        return pending.is_begun && pending.listed == pending.clients.size();
    };
    return !awaited_.has_any() && !pending_.empty() &&
           std::ranges::all_of(pending_, is_begun_and_listed);
}

bool TakeOver::is_adopted_from_several(const Endpoint& address) const {
    return std::ranges::count_if(pending_, [&](const Pending& pending) {
               return pending.assignment.address == address;
           }) > 1;
}

std::set<Endpoint> TakeOver::half_adopted() const {
    std::set<Endpoint> addresses;
    for (const Pending& pending : pending_) {
        if (pending.is_begun) addresses.insert(pending.assignment.address);
    }
    return addresses;
}

std::set<Endpoint> TakeOver::inheriting() const {
    std::set<Endpoint> addresses;
    for (const Pending& pending : pending_) addresses.insert(pending.assignment.address);
    return addresses;
}

}  // namespace romano::cluster
