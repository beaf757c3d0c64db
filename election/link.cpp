#include "election/link.h"

namespace romano::election {

void LinkDetector::on_beacon(Instant now, NodeId node) {
    const auto doubted = doubted_.find(node);
    if (doubted != doubted_.end()) {
        if (doubted->second-- > 0) return;
        doubted_.erase(doubted);
    }
    silence_.on_beacon(now, node);
}

void LinkDetector::on_link(Instant now, NodeId node, Link link) {
    if (link == Link::up) {
        doubted_.erase(node);
        return;
    }
    doubted_[node] = beacons_on_their_way;
    silence_.on_gone(now, node);
}

}  // namespace romano::election
