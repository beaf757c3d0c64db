#include "overlay/member/member_facts.h"

#include <algorithm>

#include "overlay/member/member.h"

namespace romano::overlay {

MemberFacts Member::facts() const {
    MemberFacts out;
    const auto& own = cluster_.own_log();
    out.view = cluster_.view();
    out.log_last = own.last();
    out.log_safe = cluster_.watermark().safe();
    out.log_events_kept = own.history().events_kept();
    out.views = cluster_.views_seen();
    out.take_overs = cluster_.take_over().inherited();
    out.condition = cluster_.membership().condition();
    const auto leader = cluster_.leadership().leader;
    out.leads = leader == cluster::node_of(own.id().broker);
    for (const auto& [id, peer] : cluster_.membership().peers()) {
        if (leader == cluster::node_of(id)) out.leader = peer.beacon.name;
        const auto log = cluster_.peer_logs().find(peer.beacon.log);
        out.peers.push_back(
            {.name = peer.beacon.name,
             .alive = peer.alive,
             .applied = log == cluster_.peer_logs().end() ? 0 : log->second.applied(),
             .holds = cluster_.watermark().held_by(peer.beacon.log)});
    }
    if (out.leads) out.leader = options_.name;
    std::ranges::sort(out.peers, {}, &PeerFacts::name);
    out.replacements = replacements_;
    out.leases_lost = leases_lost_;
    out.held_output = held_.size();
    out.held_output_dropped = held_.dropped();
    out.waiting_input = waiting_.size();
    out.waiting_input_dropped = waiting_.dropped();
    if (uplink_) out.uplink = uplink_->facts();
    return out;
}

}  // namespace romano::overlay
