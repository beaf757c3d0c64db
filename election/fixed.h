// The plain detector: so many beacon times of silence mean death.
//
// Silence is counted in ticks of the observer's own clock, one a beacon time and none made up for
// later: an observer that was paused for a second has missed one tick, not a hundred, and accuses
// nobody.
#pragma once

#include "election/failure_detector.h"
#include "romano/base/flat_map.h"

namespace romano::election {

class FixedDetector final : public FailureDetector {
public:
    explicit FixedDetector(const DetectorOptions& options);

    void on_beacon(Instant now, NodeId node) override;
    void on_gone(Instant now, NodeId node) override;
    void on_tick(Instant now) override;
    [[nodiscard]] Instant next_wakeup() const override { return next_tick_; }
    [[nodiscard]] bool is_alive(NodeId node) const override { return missed_.contains(node); }
    [[nodiscard]] std::vector<NodeId> take_suspects() override;
    [[nodiscard]] Duration detection_time() const override { return timeout_; }

private:
    Duration beacon_every_;
    Duration timeout_;
    std::int64_t missed_limit_;
    Instant next_tick_ = Instant::min();
    FlatMap<NodeId, std::int64_t> missed_;  // ticks since the last beacon, of the living
    std::vector<NodeId> suspects_;
};

}  // namespace romano::election
