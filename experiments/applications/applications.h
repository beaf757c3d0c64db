// The applications of the ROMANO paper (section "Application Implementation Examples") on simulated
// robots, and one more. Each writes <name>.csv, <name>.svg and the gnuplot script of the picture
// into a folder, and throws std::runtime_error when the robots do not end where they should.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace romano::experiments {

struct ApplicationOptions {
    std::string host = "127.0.0.1";
    std::uint16_t port = 1883;
    std::filesystem::path output = ".";
    std::filesystem::path broker_program = {};  // for those that start brokers of their own
    std::uint32_t domain = 60;                  // their first DDS domain
    std::string network = "127.60.0";           // and their addresses
    std::uint64_t seed = 1;
    bool brief = false;  // fewer robots, a shorter way
};

/// Movement messages to subgroups: two teams of three robots, told apart by the topic that the
/// operator made each subscribe to, drive two figures; a message to one robot's id moves it alone.
void run_group_control(const ApplicationOptions& options);

/// One robot drives a course and tells where it is; two others listen and copy its path, each from
/// its own place.
void run_path_copy(const ApplicationOptions& options);

/// Two robots disperse along a line and keep the strength of their radio link: each in turn asks
/// the other for a packet (UDP-SEND-REQ, UDP-SEND-GO), and steps away from it or towards it by how
/// strongly that is heard. Throws when the strength does not settle.
void run_radio_distance(const ApplicationOptions& options);

/// Two networks of robots, on IPv6 and on IPv4, with brokers that it starts, exchange messages
/// through a mosquitto with TLS and credentials; a leader is killed meanwhile. Throws when a
/// message of QoS 1 or 2 is lost, or one of QoS 0 or 2 is doubled or looped.
void run_bridge(const ApplicationOptions& options);

/// Robots drive between the cells of three brokers, which it starts, and talk to the nearest.
/// Throws when a move loses a message of QoS 1 or 2, or more than two of QoS 0 at 20 a second.
void run_roaming(const ApplicationOptions& options);

}  // namespace romano::experiments
