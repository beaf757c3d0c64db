// The times that suit a kind of network: `profile` in the settings of a broker, whose README has
// the table, and what the simulator searches.
#pragma once

#include <array>
#include <chrono>
#include <string_view>

namespace romano::election {

struct Profile {
    std::string_view name;
    std::chrono::milliseconds beacon_every;
    std::chrono::milliseconds detection_timeout;
    double phi_threshold;
    std::chrono::milliseconds t_retry;  // MQTT-SN 1.2 section 7.2, towards clients
    int n_retry;                        // a client that is out of reach for 40 s is lost
};

/// `lan`: a host that takes a core for 20 ms costs no failover (bench/failover). Radios lose single
/// frames and whole tenths of seconds; a mesh of 802.15.4 has no room for many beacons either.
inline constexpr std::array profiles = {
    Profile{"lan", std::chrono::milliseconds{10}, std::chrono::milliseconds{50}, 8,
            std::chrono::milliseconds{1'000}, 40},
    Profile{"wifi", std::chrono::milliseconds{50}, std::chrono::milliseconds{500}, 10,
            std::chrono::milliseconds{2'000}, 20},
    Profile{"mesh", std::chrono::milliseconds{1'000}, std::chrono::milliseconds{6'000}, 12,
            std::chrono::milliseconds{10'000}, 4},
};

}  // namespace romano::election
