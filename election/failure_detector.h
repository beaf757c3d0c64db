// Turns missing beacons into suspicion: the one interface of all failure detectors.
//
// Detectors count missed ticks of the observer's own clock without catching up, so that a stall of
// the observer is not blamed on its peers.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "election/elector.h"
#include "romano/base/time.h"

namespace romano::election {

/// A connection to a node's process that its kernel closes when the process ends.
enum class Link : std::uint8_t {
    up,
    lost,  // it was up, was closed from the other side, and the process takes no new one
};

class FailureDetector {
public:
    virtual ~FailureDetector() = default;

    /// A sign of life; a node that was suspected or unknown is alive again.
    virtual void on_beacon(Instant now, NodeId node) = 0;
    /// The node said goodbye, or something better than beacons knows that it is gone.
    virtual void on_gone(Instant now, NodeId node) = 0;
    /// It was started anew: nothing from before says anything about it.
    virtual void on_restart(NodeId) {}
    /// Detectors on beacons alone do not look at it.
    virtual void on_link(Instant, NodeId, Link) {}
    virtual void on_tick(Instant now) = 0;
    [[nodiscard]] virtual Instant next_wakeup() const = 0;

    [[nodiscard]] virtual bool is_alive(NodeId node) const = 0;
    /// Newly suspected nodes since the last call; cleared by it.
    [[nodiscard]] virtual std::vector<NodeId> take_suspects() = 0;
    /// Silence that leads to suspicion, as of now.
    [[nodiscard]] virtual Duration detection_time() const = 0;
};

struct DetectorOptions {
    Duration beacon_every{};
    Duration timeout{};          // fixed: silence after which a node is suspected
    double phi_threshold = 8.0;  // phi-accrual: suspicion is -log10 of the chance of an error
};

/// By name (see detector_names()). Null for an unknown one.
[[nodiscard]] std::unique_ptr<FailureDetector> make_detector(std::string_view name,
                                                             const DetectorOptions& options);
[[nodiscard]] std::span<const std::string_view> detector_names();

}  // namespace romano::election
