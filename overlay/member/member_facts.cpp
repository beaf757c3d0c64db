#include "overlay/member/member_facts.h"

#include <algorithm>

#include "overlay/cluster/cluster_core.h"

namespace romano::overlay {

MemberFacts facts_of(const cluster::ClusterCore& cluster) {
    MemberFacts out;
    const auto& own = cluster.own_log();
    out.view = cluster.view();
    out.log_last = own.last();
    out.log_safe = cluster.watermark().safe();
    out.log_events_kept = own.history().events_kept();
    out.views = cluster.views_seen();
    out.take_overs = cluster.take_over().inherited();
    out.condition = cluster.membership().condition();
    const auto leader = cluster.leadership().leader;
    out.leads = leader == cluster::node_of(own.id().broker);
    for (const auto& [id, peer] : cluster.membership().peers()) {
        if (leader == cluster::node_of(id)) out.leader = peer.beacon.name;
        const auto log = cluster.peer_logs().find(peer.beacon.log);
        out.peers.push_back(
            {.name = peer.beacon.name,
             .alive = peer.alive,
             .applied = log == cluster.peer_logs().end() ? 0 : log->second.applied(),
             .holds = cluster.watermark().held_by(peer.beacon.log)});
    }
    std::ranges::sort(out.peers, {}, &PeerFacts::name);
    return out;
}

}  // namespace romano::overlay
