// What happened to the datagrams, for people and for metrics. Plain numbers that only grow.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "broker/core/session_image.h"
#include "romano/mqttsn/codec.h"

namespace romano::broker {

/// Why something that arrived had no effect, or something that waited was given up.
enum class Drop : std::uint8_t {
    wrong_direction,    // a message that only brokers send
    unknown_sender,     // no session for it, and no CONNECT
    stranger_rate,      // over a rate at which addresses without a session are heeded, or answered
    unexpected,         // an answer to nothing asked, a will out of turn
    invalid_topic,      // unknown id, bad name or filter
    too_large,          // a payload over the limit
    queue_full,         // the session's queue was full
    retries_exhausted,  // the client did not answer
    refused_by_client,  // the client answered with a return code other than 0
    encapsulation,      // a forwarder's frame that holds none or a nested one
    no_room,            // a table was full: answered by "congestion" where there is an answer
    never_retained,  // Retain, on a message that is not to be kept: it was delivered all the same
    output_full,     // one message to so many clients that the rest of them goes without
};
inline constexpr std::size_t drop_kinds = 13;

/// What somebody may not (permissions.h).
enum class Refused : std::uint8_t {
    publish,
    register_,  // a topic id to publish under
    subscribe,
    will,      // when it was made, or was to be said
    delivery,  // a message of a topic that its subscriber may not read
};
inline constexpr std::size_t refused_kinds = 5;

struct Counters {
    std::array<std::uint64_t, 256> received_by_type{};  // by MsgType
    std::array<std::uint64_t, 256> sent_by_type{};
    std::array<std::uint64_t, mqttsn::malformed_kinds> malformed{};
    std::uint64_t malformed_total = 0;  // of all kinds: whoever calls can see that one was
    std::array<std::uint64_t, drop_kinds> dropped{};
    std::array<std::uint64_t, refused_kinds> refused{};
    std::uint64_t publishes_received = 0;
    std::uint64_t publishes_sent = 0;
    std::uint64_t retransmissions = 0;
    std::uint64_t cell_publishes = 0;    // datagrams to the cell's group: one for many listeners
    std::uint64_t cell_deliveries = 0;   // the listeners that they were for
    std::uint64_t cell_repairs = 0;      // of those at QoS 1, whom a unicast had to follow
    std::uint64_t late_answers = 0;      // to publishers that were ahead of their receivers
    std::uint64_t sessions_expired = 0;  // kept sessions (Limits::session_expiry_s)
    /// Kept sessions that went while their clients were away: too many of one IP address, or to
    /// make room (Limits::kept_per_address, sessions and memory_mib).
    std::uint64_t sessions_forgotten = 0;

    void count(Refused what) { ++refused[static_cast<std::size_t>(what)]; }
};

/// What is there now: counted when somebody asks, so that nothing is kept for it.
struct Census {
    std::array<std::size_t, session_states> sessions{};  // by SessionState
    std::size_t subscriptions = 0;
    std::size_t topics = 0;         // ids given to clients
    std::size_t queued = 0;         // messages that wait for clients, in flight ones too
    std::size_t longest_queue = 0;  // of one session
    std::size_t in_flight = 0;      // exchanges that wait for a client's answer
    std::size_t unreleased = 0;     // QoS 2 publishes whose PUBREL is outstanding
    std::size_t retained = 0;
};

}  // namespace romano::broker
