// When a member tells people about the brokers that it knows, and which of that is news: the
// retained messages of `status_topic.h`, every second and when the view, the leader or who serves
// which address changes.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "broker/core/broker_core.h"
#include "overlay/cluster/cluster_core.h"

namespace romano::overlay {

class StatusTeller {
public:
    /// Publishes what has changed since it was told; to be asked at each tick.
    void on_tick(Instant now, const cluster::ClusterCore& cluster, broker::BrokerCore& broker,
                 broker::Actions& out);
    /// The broker's core is a new one, which nobody has told anything.
    void forget() { told_.clear(); }

private:
    void tell(Instant now, const cluster::ClusterCore& cluster, broker::BrokerCore& broker,
              broker::Actions& out);

    Instant next_ = Instant::min();
    cluster::ViewNumber told_view_;
    election::Leadership told_leadership_;
    std::vector<Endpoint> told_serving_;
    std::uint64_t looked_at_ = 0;    // Membership::news(), when it was compared with that last
    std::vector<Endpoint> claimed_;  // as well
    std::map<std::string, std::string> told_;  // by topic: only changes are published
};

}  // namespace romano::overlay
