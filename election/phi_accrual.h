// The phi accrual failure detector (Hayashibara et al. 2004) on beacons: suspicion grows with how
// improbable the silence is, given the gaps between this node's beacons so far.
//
// Time is counted in ticks of the observer's own clock, one a beacon interval, never more than one
// for a late tick: the observer's stall adds one tick of silence and not the length of the stall.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <vector>

#include "election/failure_detector.h"

namespace romano::election {

class PhiAccrualDetector final : public FailureDetector {
public:
    explicit PhiAccrualDetector(const DetectorOptions& options);

    void on_beacon(Instant now, NodeId node) override;
    void on_gone(Instant now, NodeId node) override;
    void on_tick(Instant now) override;
    [[nodiscard]] Instant next_wakeup() const override { return next_tick_; }

    [[nodiscard]] bool is_alive(NodeId node) const override;
    [[nodiscard]] std::vector<NodeId> take_suspects() override;
    /// The longest over all living nodes, as of now.
    [[nodiscard]] Duration detection_time() const override;

    /// -log10 of the probability that a beacon still comes after that silence; for traces and
    /// plots.
    [[nodiscard]] double phi(NodeId node) const;

private:
    static constexpr std::size_t window = 200;  // gaps remembered a node

    struct Peer {
        std::deque<double> gaps;  // in beacon intervals
        double sum = 0;
        double sum_of_squares = 0;
        double silence = 0;  // in beacon intervals, by the observer's ticks
        Instant last_beacon;
        bool alive = true;

        [[nodiscard]] double mean() const;
        [[nodiscard]] double deviation() const;
    };

    [[nodiscard]] double phi_of(const Peer& peer, double silence) const;

    DetectorOptions options_;
    double deviations_at_threshold_;
    std::map<NodeId, Peer> peers_;
    std::vector<NodeId> suspects_;
    Instant next_tick_ = Instant::min();
};

}  // namespace romano::election
