#include "election/fixed.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::election {

FixedDetector::FixedDetector(const DetectorOptions& options)
    : beacon_every_(options.beacon_every),
      timeout_(options.timeout),
      missed_limit_(std::max<std::int64_t>(
          2, (options.timeout + options.beacon_every - Duration{1}) / options.beacon_every)) {
    assert(options.beacon_every > Duration::zero());
}

void FixedDetector::on_beacon(Instant, NodeId node) {
    std::erase(suspects_, node);
    missed_[node] = 0;
}

void FixedDetector::on_gone(Instant, NodeId node) {
    if (missed_.erase(node) != 0) suspects_.push_back(node);
}

void FixedDetector::on_tick(Instant now) {
    if (now < next_tick_) return;
    next_tick_ = now + beacon_every_;
    for (auto& [node, missed] : missed_) {
        if (++missed >= missed_limit_) suspects_.push_back(node);
    }
    erase_if(missed_, [this](const auto& entry) { return entry.second >= missed_limit_; });
}

std::vector<NodeId> FixedDetector::take_suspects() {
    return std::exchange(suspects_, {});
}

}  // namespace romano::election
