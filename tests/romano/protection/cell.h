// One robot and brokers that hold its key, all of whose shells store at once.
#pragma once

#include <optional>
#include <string_view>

#include "romano/protection/broker_end.h"
#include "romano/protection/robot_end.h"
#include "tests/romano/protection/hex.h"

namespace romano::protection {

inline const DirectionKeys robots_keys = direction_keys({counting_array<16>()});
inline const DirectionKeys another_robots_keys = direction_keys({counting_array<16>(1)});
inline constexpr std::string_view robots_name = "abcd1234";
inline const Octets pingreq = octets("0216");
inline const Octets pingresp = octets("0217");

struct Robot {
    explicit Robot(std::uint32_t stored = 0) : end(robots_keys, robots_name, stored) {}
    Octets seal(const Octets& message = pingreq) {
        store();
        Octets packet(message.size() + most_overhead);
        packet.resize(end.seal(message, packet));
        return packet;
    }
    bool takes(Octets packet) { return !end.open(packet).empty(); }
    std::uint32_t refused(Refusal why) const { return end.refusals().of(why); }
    void store() {
        if (const auto bound = end.reserve().to_store()) end.reserve().on_stored(*bound);
    }

    RobotEnd end;
};

struct Broker {
    explicit Broker(std::uint8_t identity, std::uint32_t stored = 0,
                    std::optional<Heard> heard = std::nullopt)
        : reserve(stored),
          end(robots_keys, robots_name, counting_array<8>(identity), reserve, heard) {}
    Octets seal(const Octets& message = pingresp) {
        if (const auto bound = reserve.to_store()) reserve.on_stored(*bound);
        Octets packet(message.size() + most_overhead);
        packet.resize(end.seal(message, packet));
        return packet;
    }
    bool takes(Octets packet) {
        const bool taken = !end.open(packet).empty();
        if (const auto heard = end.to_store()) end.on_stored(*heard);
        return taken;
    }
    std::uint32_t refused(Refusal why) const { return end.refusals().of(why); }

    Reserve reserve;
    BrokerEnd end;
};

}  // namespace romano::protection
