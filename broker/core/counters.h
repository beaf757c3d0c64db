// What happened to the datagrams, for people and for metrics. Plain numbers that only grow.
#pragma once

#include <array>
#include <cstdint>

#include "romano/mqttsn/codec.h"

namespace romano::broker {

/// Why something that arrived had no effect, or something that waited was given up.
enum class Drop : std::uint8_t {
    wrong_direction,    // a message that only brokers send
    unknown_sender,     // no session for it, and no CONNECT
    stranger_rate,      // as unknown_sender, but over the rate that is answered
    unexpected,         // an answer to nothing asked, a will out of turn
    invalid_topic,      // unknown id, bad name or filter
    too_large,          // a payload over the limit
    queue_full,         // the session's queue was full
    retries_exhausted,  // the client did not answer
    refused_by_client,  // the client answered with a return code other than 0
    encapsulation,      // a forwarder's frame that holds none or a nested one
    no_room,            // a table was full: answered by "congestion" where there is an answer
};
inline constexpr std::size_t drop_kinds = 11;

struct Counters {
    std::array<std::uint64_t, 256> received_by_type{};  // by MsgType
    std::array<std::uint64_t, 256> sent_by_type{};
    std::array<std::uint64_t, mqttsn::malformed_kinds> malformed{};
    std::array<std::uint64_t, drop_kinds> dropped{};
    std::uint64_t publishes_received = 0;
    std::uint64_t publishes_sent = 0;
    std::uint64_t retransmissions = 0;
};

}  // namespace romano::broker
