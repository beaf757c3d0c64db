#include "overlay/cluster/ownership/heirs.h"

#include <algorithm>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "overlay/cluster/replication/own_log.h"

namespace romano::cluster {
namespace {

std::optional<Seq> held_of(const ViewHoldings& holdings, const LogId& log) {
    return broker::seq_of(holdings.holds, log);
}

/// Who answered so can send the log's events after `seq`.
bool has_kept_after(const ViewHoldings& holdings, const LogId& log, Seq seq) {
    return std::ranges::none_of(holdings.kept_after, [&](const LogPosition& kept) {
        return kept.log == log && kept.seq > seq;
    });
}

/// Who holds the log up to its end, and can send what follows `seq`: one that has it from a
/// snapshot may hold none of that as events.
std::optional<BrokerId> sender_of_tail(const Answers& answers, const LogPosition& end, Seq seq) {
    const auto found = std::ranges::find_if(answers.holdings, [&](const auto& entry) {
        return held_of(entry.second, end.log) == end.seq &&
               has_kept_after(entry.second, end.log, seq);
    });
    if (found == answers.holdings.end()) return std::nullopt;
    return found->first.broker;
}

/// Holds it, but for a last batch perhaps, which comes at once. One that has just started knows
/// that the log is there, and no more; one that was cut off lacks what the others do not keep for
/// it.
bool holds(const ViewHoldings& holdings, const LogId& log, Seq end) {
    const auto held = held_of(holdings, log);
    return held && (*held > 0 || end == 0) && *held + events_per_batch >= end;
}

bool is_outdated(const ViewHoldings& holdings, const LogId& log) {
    return std::ranges::count(holdings.outdated, log) > 0;
}

/// A later life of its broker is known: others went on for this one.
bool is_succeeded(const Answers& answers, const std::map<LogId, Seq>& ends, const LogId& log) {
    const auto next = ends.upper_bound(log);
    return (next != ends.end() && next->first.broker == log.broker) ||
           answers.view.has_later_life_of(log);
}

/// Whose answers count for a log: those who were there all the time. Whoever was replaced knows of
/// sessions that have lived on elsewhere since; better than nothing when nobody else holds the last
/// log of a broker.
class Witnesses {
public:
    Witnesses(const Answers& answers, const std::map<LogId, Seq>& ends) {
        for (const auto& log_and_end : ends) {
            const LogId& log = log_and_end.first;
            const bool is_known = std::ranges::any_of(answers.holdings, [&](const auto& entry) {
                return !is_outdated(entry.second, log) &&
                       holds(entry.second, log, log_and_end.second);
            });
            if (is_known || is_succeeded(answers, ends, log)) known_.insert(log);
        }
    }
    [[nodiscard]] bool know(const LogId& log) const { return known_.contains(log); }
    [[nodiscard]] bool include(const ViewHoldings& holdings, const LogId& log) const {
        return !know(log) || !is_outdated(holdings, log);
    }

private:
    std::set<LogId> known_;  // to somebody who was there
};

/// The members that answer on the address now, its own broker first; then the one that was told to.
std::vector<BrokerId> present_servers(const Answers& answers, const Membership& membership,
                                      const Endpoint& address) {
    std::vector<BrokerId> found;
    if (std::ranges::count(answers.serving, address) > 0) found.push_back(answers.leader.broker);
    for (const LogId& member : answers.view.members) {
        const Peer* peer = membership.find(member.broker);
        if (peer == nullptr || peer->beacon.log != member || !peer->is_serving(address)) continue;
        found.insert(peer->is_home_of(address) ? found.begin() : found.end(), member.broker);
    }
    for (const auto& [member, holdings] : answers.holdings) {
        const bool is_known = std::ranges::count(found, member.broker) > 0;
        if (!is_known && std::ranges::count(holdings.serving, address) > 0) {
            found.push_back(member.broker);
        }
    }
    const auto appointed = answers.appointed.find(address);
    if (appointed != answers.appointed.end() && answers.view.contains(appointed->second)) {
        found.push_back(appointed->second.broker);
    }
    return found;
}

/// The member whose address it is.
std::optional<BrokerId> owner(const Answers& answers, const Membership& membership,
                              const Endpoint& address) {
    for (const LogId& member : answers.view.members) {
        if (member == answers.leader) {
            if (std::ranges::count(answers.home, address) > 0) return member.broker;
            continue;
        }
        const Peer* peer = membership.find(member.broker);
        if (peer != nullptr && peer->is_home_of(address)) return member.broker;
    }
    return std::nullopt;
}

std::map<BrokerId, std::uint64_t> loads(const Answers& answers, const Membership& membership) {
    std::map<BrokerId, std::uint64_t> load;
    for (const LogId& member : answers.view.members) {
        const Peer* peer = membership.find(member.broker);
        load[member.broker] =
            peer != nullptr ? peer->beacon.sessions : std::uint64_t{answers.leader_sessions};
    }
    return load;
}

/// The members that may inherit the log: those who hold it, or will, and to whom its clients'
/// topic ids mean the same. Somebody always holds all of it.
std::vector<BrokerId> candidates(const Answers& answers, const Witnesses& witnesses,
                                 const LogPosition& end) {
    std::vector<BrokerId> found;
    for (const auto& [member, holdings] : answers.holdings) {
        if (!witnesses.include(holdings, end.log) || !holds(holdings, end.log, end.seq)) continue;
        if (std::ranges::count(holdings.foreign, end.log) > 0) continue;
        const Seq held = *held_of(holdings, end.log);
        if (held >= end.seq || sender_of_tail(answers, end, held)) found.push_back(member.broker);
    }
    return found;
}

/// Of these, those that say nothing against serving the address; all, when nobody can: then the
/// sessions wait for clients that find their new home by themselves.
std::vector<BrokerId> able_to_serve(std::vector<BrokerId> members, const Answers& answers,
                                    const Endpoint& address) {
    std::vector<BrokerId> able = members;
    for (const auto& [member, holdings] : answers.holdings) {
        if (std::ranges::count(holdings.cannot_take, address) > 0) std::erase(able, member.broker);
    }
    return able.empty() ? std::move(members) : able;
}

/// The machine's address, whatever is spoken there and at which port.
Endpoint host_of(Endpoint address) {
    address.port = 0;
    address.packets = Endpoint::Packets::plain;
    return address;
}

}  // namespace

std::map<LogId, Seq> agreed_ends(const Answers& answers) {
    std::map<LogId, Seq> last;
    for (const auto& [member, holdings] : answers.holdings) {
        for (const LogPosition& position : holdings.holds) {
            Seq& seq = last[position.log];
            seq = std::max(seq, position.seq);
        }
    }
    std::map<LogId, Seq> ends;
    for (const auto& [log, seq] : last) {
        std::optional<Seq> known;  // to those who were there
        for (const auto& [member, holdings] : answers.holdings) {
            if (is_outdated(holdings, log) || !holds(holdings, log, seq)) continue;
            known = std::max(known, held_of(holdings, log));
        }
        ends.emplace(
            log, known ? *known : std::min(seq, broker::seq_of(answers.ended, log).value_or(seq)));
    }
    return ends;
}

std::vector<Assignment> assign(const Answers& answers, const std::map<LogId, Seq>& ends,
                               const Membership& membership) {
    const Witnesses witnesses(answers, ends);
    // What only those know who were replaced comes last: the others have what is newer.
    std::set<std::tuple<bool, LogId, Endpoint>> left;
    for (const auto& [member, holdings] : answers.holdings) {
        for (const auto& [log, address] : holdings.addresses) {
            if (witnesses.include(holdings, log)) left.emplace(!witnesses.know(log), log, address);
        }
    }
    auto load = loads(answers, membership);
    std::map<Endpoint, BrokerId> chosen;  // one heir an address, however many logs named it
    std::map<std::pair<LogId, Endpoint>, BrokerId> hosts;   // two machines cannot have one
    std::multimap<std::ptrdiff_t, Assignment> assignments;  // who has the address comes first
    for (const auto& [comes_last, log, address] : left) {
        const auto end = ends.find(log);
        if (end == ends.end()) continue;
        std::vector<BrokerId> wanted = present_servers(answers, membership, address);
        if (chosen.contains(address)) wanted.push_back(chosen.at(address));
        if (const auto home = owner(answers, membership, address)) wanted.push_back(*home);
        const auto host = hosts.find({log, host_of(address)});
        if (host != hosts.end()) wanted.push_back(host->second);
        const auto able =
            able_to_serve(candidates(answers, witnesses, {log, end->second}), answers, address);
        if (able.empty()) continue;
        // One that serves the address, or will, but does not hold the log gets the sessions from
        // an heir.
        const auto best = std::ranges::find_first_of(wanted, able);
        const BrokerId heir =
            best != wanted.end()
                ? *best
                : *std::ranges::min_element(able, {}, [&](BrokerId id) { return load.at(id); });
        chosen.try_emplace(address, heir);
        hosts.try_emplace({log, host_of(address)}, heir);
        const Peer* dead = membership.find(log.broker);
        load[heir] += 1 + (dead != nullptr ? dead->beacon.sessions : 0);
        assignments.emplace(
            best - wanted.begin(),
            Assignment{.end = {log, end->second}, .address = address, .heir = heir});
    }
    std::vector<Assignment> sorted;
    sorted.reserve(assignments.size());
    for (auto& assignment : assignments) sorted.push_back(std::move(assignment.second));
    return sorted;
}

std::vector<std::pair<BrokerId, Fetch>> missing_tails(const Answers& answers,
                                                      const std::map<LogId, Seq>& ends) {
    std::vector<std::pair<BrokerId, Fetch>> requests;
    for (const auto& [log, end] : ends) {
        for (const auto& [member, holdings] : answers.holdings) {
            const auto held = held_of(holdings, log);
            if (held.value_or(0) == 0 || *held >= end) continue;
            const auto sender = sender_of_tail(answers, {log, end}, *held);
            if (!sender) continue;
            requests.emplace_back(*sender, Fetch{.after = {log, *held}, .to = member.broker});
        }
    }
    return requests;
}

}  // namespace romano::cluster
