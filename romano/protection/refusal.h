// Why a packet is not sent, or not accepted; each reason is counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace romano::protection {

enum class Refusal : std::uint8_t {
    // not sent
    too_long,       // the room for the packet is too small
    unstored,       // no number may be used before the shell has stored the reserve
    used_up,        // all numbers are used: the robot needs a new key, the broker a new identity
    robot_unheard,  // the broker has heard no packet of the robot: it knows not of the robot's run
    // not accepted
    malformed,  // no packet: the length is not the datagram's, or too short for what must be there
    unprotected,     // an MQTT-SN message as it is
    unknown_scheme,  // flags or scheme are others than ours
    unknown_sender,  // not the robot whose key this is
    other_run,       // sealed before the robot's present run, or for another robot's
    replayed,        // a number that was there before, or is too old to tell
    bad_tag,         // forged, damaged, or by another key
    forwarded,       // a forwarder encapsulation inside: a robot speaks for itself alone
};
inline constexpr std::size_t refusal_kinds = 12;

class Refusals {
public:
    void count(Refusal why) { ++counts_[static_cast<std::size_t>(why)]; }
    [[nodiscard]] std::uint32_t of(Refusal why) const {
        return counts_[static_cast<std::size_t>(why)];
    }

private:
    std::array<std::uint32_t, refusal_kinds> counts_{};
};

}  // namespace romano::protection
