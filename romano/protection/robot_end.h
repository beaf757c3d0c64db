// A robot's end of its protected packets: what its client sends is sealed, what its brokers send is
// opened. No storage for datagrams, no socket, no flash: reserve.h says what is to be stored.
//
// A broker is whoever knows the robot's key; the first packet of a broker is the first that is
// opened. No packet is accepted twice, whichever broker sealed it, also not after a restart of
// either: see the README.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/protection/keys.h"
#include "romano/protection/packet.h"
#include "romano/protection/refusal.h"
#include "romano/protection/replay_window.h"
#include "romano/protection/reserve.h"
#include "romano/protection/sealer.h"

namespace romano::protection {

class RobotEnd {
public:
    /// How many brokers have a window each. With more, the robot begins a new run when the one that
    /// was longest silent is forgotten, and is deaf until the others have heard of it.
    static constexpr std::size_t brokers = 4;

    /// The keys outlive it: they may lie in flash.
    RobotEnd(const DirectionKeys& keys, std::string_view client_id, std::uint32_t stored)
        : reserve_(stored),
          sealer_(keys.to_broker, sender_id(client_id), reserve_),
          to_robot_(keys.to_robot),
          run_{stored} {}
    RobotEnd(const RobotEnd&) = delete;
    RobotEnd& operator=(const RobotEnd&) = delete;

    /// Nothing is sealed before its first bound is stored.
    [[nodiscard]] Reserve& reserve() { return reserve_; }

    /// The packet's size, 0 when it is refused. `message` may lie in `out`.
    std::size_t seal(Bytes message, MutableBytes out) {
        return sealer_.seal(run_, message, out, refusals_);
    }

    /// The message, which lies in `packet`; empty when it is refused.
    Bytes open(MutableBytes packet);

    /// Before a CONNECT after a lost connection: a broker that restarted takes what is left of this
    /// block for old.
    void skip_block() { sealer_.skip_block(); }

    [[nodiscard]] const Refusals& refusals() const { return refusals_; }

private:
    struct Broker {
        SenderId id;
        ReplayWindow window;
    };

    [[nodiscard]] std::size_t place_of(const SenderId& id) const;
    void note(std::size_t place, const Fields& fields);
    Bytes refuse(Refusal why);

    Reserve reserve_;
    Sealer sealer_;
    const Key& to_robot_;
    RunId run_;
    std::size_t known_ = 0;
    std::array<Broker, brokers> brokers_{};  // who was heard last stands first
    Refusals refusals_;
};

}  // namespace romano::protection
