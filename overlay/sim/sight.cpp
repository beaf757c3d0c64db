#include "overlay/sim/sight.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "broker/core/log_event.h"
#include "overlay/cluster/cluster_core.h"
#include "overlay/sim/cluster_broker.h"

namespace romano::sim {

namespace {

/// The messages that a home says it routes, of those events that were acknowledged since.
void find_references(const LogCopy& copy, broker::Seq before, const cluster::ClusterCore& cluster,
                     std::vector<Reference>& found) {
    const cluster::PeerLog& log = cluster.peer_logs().at(copy.log);
    const cluster::LogHistory& history = log.history();
    if (copy.acknowledged <= before || !history.reaches_back_to(before)) return;
    for (const auto& event : history.events_after(before, copy.acknowledged - before)) {
        const auto* routed = std::get_if<broker::Routed>(&*event);
        if (routed == nullptr) continue;
        const auto named = cluster.peer_logs().find(routed->message.log);
        const bool is_held =
            (named != cluster.peer_logs().end() && named->second.holds(routed->message.seq)) ||
            !log.mirror().is_unresolved(routed->message);
        found.push_back({copy.log, routed->message, is_held});
    }
}

void look_at_seals(const cluster::LogHistory& own, Sight& sight) {
    sight.sealed.clear();
    const broker::Seq before = std::exchange(sight.own_last, own.last());
    if (own.last() <= before || !own.reaches_back_to(before)) return;
    for (const auto& event : own.events_after(before, own.last() - before)) {
        if (const auto* sealed = std::get_if<broker::Sealed>(&*event))
            sight.sealed.push_back(*sealed);
    }
}

void look_at_copies(const cluster::ClusterCore& cluster, Sight& sight) {
    sight.references.clear();
    std::vector<LogCopy> copies;
    copies.reserve(cluster.peer_logs().size());
    for (const auto& [id, log] : cluster.peer_logs()) {
        LogCopy copy{id, log.applied(), cluster.held_of(id, log)};
        if (const auto end = log.agreed_end()) copy.end = LogCopy::End{end->seq, end->in};
        const LogCopy* before = sight.copy_of(id);
        if (before != nullptr && !log.is_frozen()) {
            find_references(copy, before->acknowledged, cluster, sight.references);
        }
        copies.push_back(copy);
    }
    sight.copies = std::move(copies);
}

void look_at_members(const cluster::ClusterCore& cluster, const broker::BrokerCore& broker,
                     Sight& sight) {
    sight.hears.clear();
    sight.higher.clear();
    for (const broker::LogId& member : cluster.view().members) {
        if (member == sight.log || !cluster.membership().is_heard(member)) continue;
        sight.hears.push_back(member);
        const auto log = cluster.peer_logs().find(member);
        if (log == cluster.peer_logs().end()) continue;
        if (log->second.is_frozen() || log->second.is_foreign()) continue;
        for (const std::string& client : sight.speaks_to) {
            const broker::SessionHeader* theirs = log->second.mirror().header(client);
            if (theirs == nullptr || !broker::outranks(*theirs, *broker.header(client))) continue;
            sight.higher.push_back({client, member});
        }
    }
}

void look_at_moves(const cluster::ClusterCore& cluster, const broker::BrokerCore& broker,
                   Sight& sight) {
    sight.leaving.clear();
    sight.twice.clear();
    for (const auto& [client, leaving] : cluster.departures().all()) {
        if (broker.header(client) != nullptr) sight.twice.push_back(client);
        sight.leaving.push_back({{sight.log, leaving.session.at}, leaving.session.image});
    }
    sight.mirrored.clear();
    for (const auto& [id, log] : cluster.peer_logs()) {
        for (const auto& [client, session] : log.moved()) {
            sight.mirrored.push_back({{id, session.at}, session.image});
        }
    }
}

}  // namespace

const LogCopy* Sight::copy_of(const broker::LogId& wanted) const {
    const auto found = std::ranges::lower_bound(copies, wanted, {}, &LogCopy::log);
    return found == copies.end() || found->log != wanted ? nullptr : &*found;
}

void look_at(const ClusterBroker& broker, Instant now, const std::vector<std::string>& clients,
             Sight& sight) {
    const overlay::Member& member = broker.member();
    const cluster::ClusterCore& cluster = member.cluster();
    if (sight.log != member.log()) sight = {};  // a new life
    sight.name = broker.name();
    sight.log = member.log();
    sight.view = cluster.view();
    sight.promised = cluster.promised();
    sight.times = cluster.times();
    sight.shown = cluster.watermark().safe();
    // Who is only silent counts until the next view.
    const bool may_one_live = std::ranges::any_of(sight.view.members, [&](const auto& log) {
        return log != sight.log && !cluster.membership().has_ended(log);
    });
    sight.holders = std::min<std::size_t>(
        broker.options().cluster.acks,
        std::max<std::size_t>(cluster.live_peers().size(), may_one_live ? 1 : 0));
    sight.own_events = cluster.own_log().history().events_kept();
    sight.said_from = broker.said_from();
    std::erase_if(sight.said_from,  // the shell drops what no socket of its own says
                  [&](const Endpoint& via) { return !cluster.addresses().is_serving(via); });
    sight.speaks_from.clear();
    for (const Endpoint& address : cluster.addresses().serving()) {
        if (member.may_speak_from(address)) sight.speaks_from.push_back(address);
    }
    sight.speaks_to.clear();
    for (const std::string& client : clients) {
        const broker::SessionHeader* session = member.broker().header(client);
        if (session != nullptr && std::ranges::count(sight.speaks_from, session->via) > 0) {
            sight.speaks_to.push_back(client);
        }
    }
    look_at_members(cluster, member.broker(), sight);
    look_at_seals(cluster.own_log().history(), sight);
    look_at_copies(cluster, sight);
    look_at_moves(cluster, member.broker(), sight);
    look_again(broker, now, sight);
}

void look_again(const ClusterBroker& broker, Instant now, Sight& sight) {
    sight.is_speaking = broker.is_running() && broker.member().may_speak(broker.clock().at(now));
}

}  // namespace romano::sim
