// The cluster's settings; profiles set the times together.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "overlay/cluster/times.h"
#include "romano/base/time.h"

namespace romano::cluster {

inline constexpr std::uint32_t all_peers = std::numeric_limits<std::uint32_t>::max();

struct ClusterOptions {
    std::string elector = "component";
    std::vector<std::string> voters;  // raft: the names of the brokers that vote; empty: nobody can
    std::string detector = "fixed";
    std::uint32_t rank = 0;    // configured capability: the highest leads
    std::uint32_t acks = 1;    // peers that must hold an event before its effect is visible
    bool acks_strict = false;  // alone: refuse with "congestion" instead of promising
    Duration beacon_every{std::chrono::milliseconds{10}};
    Duration detection_timeout{std::chrono::milliseconds{100}};
    Duration found_within{};  // by the transport: a peer that starts must prove who it is first
    Duration found_again_within{std::chrono::milliseconds{500}};  // by the transport, after a cut
    Duration people_told_every{std::chrono::seconds{1}};
    std::string
        profile;  // its name and the program's version are only compared (settings_comparison.h)
    std::string version;
    double phi_threshold = 8;  // phi-accrual: -log10 of the chance that a suspicion is wrong
    std::size_t log_events_kept = 200'000;  // for peers that lag; beyond it they need a snapshot
    std::size_t events_per_turn = 256;      // of a log, or datagrams, that are caught up with
    std::size_t sessions_per_turn = 32;     // that move, or come by a log: half a millisecond

    /// With the detection time as of now.
    [[nodiscard]] Times times(Duration detection) const {
        return {beacon_every, detection, found_within, found_again_within, people_told_every};
    }
};

}  // namespace romano::cluster
