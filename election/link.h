// Crashes by link, silence by beacons: a connection to the node that its kernel closes when its
// process dies makes a crash known at once; a node that stands still keeps its connections, and
// only its missing beacons tell (fixed.h).
//
// The last beacons of a dead node may still be on their way when its link is lost already: so many
// are not believed. More than that, or a link that is up again, mean that the loss was a false one.
#pragma once

#include <map>

#include "election/failure_detector.h"
#include "election/fixed.h"

namespace romano::election {

class LinkDetector final : public FailureDetector {
public:
    explicit LinkDetector(const DetectorOptions& options) : silence_(options) {}

    void on_beacon(Instant now, NodeId node) override;
    void on_gone(Instant now, NodeId node) override { silence_.on_gone(now, node); }
    void on_restart(NodeId node) override { doubted_.erase(node); }
    void on_link(Instant now, NodeId node, Link link) override;
    void on_tick(Instant now) override { silence_.on_tick(now); }
    [[nodiscard]] Instant next_wakeup() const override { return silence_.next_wakeup(); }
    [[nodiscard]] bool is_alive(NodeId node) const override { return silence_.is_alive(node); }
    [[nodiscard]] std::vector<NodeId> take_suspects() override { return silence_.take_suspects(); }
    [[nodiscard]] Duration detection_time() const override { return silence_.detection_time(); }

private:
    static constexpr int beacons_on_their_way = 3;

    FixedDetector silence_;
    std::map<NodeId, int> doubted_;  // beacons that are still not believed
};

}  // namespace romano::election
