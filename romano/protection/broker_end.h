// A broker's end of one robot's protected packets. No socket, no files: to_store() and reserve.h
// say what is to be stored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/protection/keys.h"
#include "romano/protection/packet.h"
#include "romano/protection/refusal.h"
#include "romano/protection/replay_window.h"
#include "romano/protection/reserve.h"
#include "romano/protection/sealer.h"

namespace romano::protection {

/// What a broker knows of a robot's packets, to go on after a restart or in another's place.
struct Heard {
    RunId run;
    std::uint32_t floor;  // lower numbers are old

    friend bool operator==(const Heard&, const Heard&) = default;
};

class BrokerEnd {
public:
    /// `broker` was drawn at random when the reserve was made and is stored beside it: so two
    /// brokers of one name, or one that lost what it stored, number under different identities. All
    /// robots share the broker's reserve; it and the keys outlive them.
    /// What is below the first packet that it opens counts as heard, if anything was before: it may
    /// have been, without whoever told of `heard` knowing.
    BrokerEnd(const DirectionKeys& keys, std::string_view client_id, const SenderId& broker,
              Reserve& reserve, std::optional<Heard> heard);

    /// The packet's size, 0 when it is refused. `message` may lie in `out`.
    std::size_t seal(Bytes message, MutableBytes out);

    /// The message, which lies in `packet`; empty when it is refused.
    Bytes open(MutableBytes packet);

    /// To be stored before what was opened has an effect: after a crash no packet is accepted
    /// again. The floor is the end of a block, so that this is seldom.
    [[nodiscard]] std::optional<Heard> to_store() const;
    void on_stored(const Heard& heard) { stored_ = heard; }

    /// Exactly: for an orderly end, after which the robot's next packet is accepted, and for a
    /// successor.
    [[nodiscard]] std::optional<Heard> heard() const;

    [[nodiscard]] const Refusals& refusals() const { return refusals_; }

private:
    Bytes refuse(Refusal why);

    Sealer sealer_;
    const Key& to_broker_;
    SenderId robot_;
    std::optional<RunId> run_;
    std::optional<Heard> stored_;
    ReplayWindow window_;
    bool is_first_ = false;  // none was opened yet, and there were some before
    Refusals refusals_;
};

}  // namespace romano::protection
