// What a client tells its owner: datagrams to send and events, in the order in which they arose.
//
// The owner keeps one Output (for many clients, when it likes) and drains it after each call; the
// next call empties it. Views in an event point into the datagram that was handed in and into the
// client: they are good until either changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "romano/base/bytes.h"
#include "romano/client/limits.h"
#include "romano/mqttsn/body.h"
#include "romano/mqttsn/messages.h"
#include "romano/mqttsn/types.h"

namespace romano::client {

/// Names one subscribe(), publish()... of this client until its end is reported. Counts up, wraps.
enum class OperationId : std::uint16_t {};

/// CONNACK accepted: operations may flow.
struct Connected {};
/// CONNACK with another return code. `congestion`: ask again after T_WAIT.
struct Refused {
    mqttsn::ReturnCode return_code;
};
/// No answer after Nretry repetitions (6.13). Waiting operations go on after the next connect().
struct Lost {};
/// By the own disconnect(), or by the broker, unasked (6.12): then connect() again.
struct Disconnected {
    bool by_broker;
};
/// The broker knows that the client sleeps; or all that it kept for the sleeper has come (6.14).
struct Asleep {};

struct Registered {
    OperationId operation;
    mqttsn::TopicId topic_id;
};
struct Subscribed {
    OperationId operation;
    mqttsn::TopicId topic_id;  // 0 for a filter with wildcards
    mqttsn::Qos granted;
};
struct Unsubscribed {
    OperationId operation;
};
/// The end of a publish(): sent (QoS -1, 0), acknowledged (1), completed (2).
struct Published {
    OperationId operation;
};
struct WillUpdated {
    OperationId operation;
};
/// The broker refused the operation, or there was no room for the topic's id here (`congestion`).
struct Failed {
    OperationId operation;
    mqttsn::ReturnCode return_code;
};
/// The broker is overloaded: nothing is asked of it for T_WAIT, then the operation is tried again.
struct Congested {};

/// A PUBLISH for the application. At QoS 2 it is told once, at QoS 1 as often as it comes.
struct Received {
    mqttsn::TopicRef topic;  // type normal: name and id; short_name: name; predefined: id
    Bytes data;
    mqttsn::Qos qos;
    bool retain;
    bool dup;
};

using Event = std::variant<Connected, Refused, Lost, Disconnected, Asleep, Registered, Subscribed,
                           Unsubscribed, Published, WillUpdated, Failed, Congested, Received>;

class Output {
public:
    Output(const Output&) = delete;
    Output& operator=(const Output&) = delete;

    [[nodiscard]] std::span<const Bytes> datagrams() const { return {datagrams_, datagram_count_}; }
    [[nodiscard]] std::span<const Event> events() const { return {events_, event_count_}; }

    // For the client.

    /// No call of the client makes more of either: what would not fit waits for the next tick.
    static constexpr std::size_t most = 3;

    void clear();
    /// Room for two more of each, and for one more datagram of any size.
    [[nodiscard]] bool has_room() const;
    void send(mqttsn::MsgType type, const mqttsn::Body& body);
    void tell(const Event& event);

protected:
    explicit Output(MutableBytes octets) : octets_(octets) {}
    ~Output() = default;

private:
    MutableBytes octets_;
    std::size_t used_ = 0;
    std::size_t datagram_count_ = 0;
    std::size_t event_count_ = 0;
    Bytes datagrams_[most];
    Event events_[most];
};

/// With its storage; for clients with the same limits or smaller ones.
template <typename Limits = HostLimits>
class OutputFor final : public Output {
public:
    OutputFor() : Output(octets_) {}

private:
    std::uint8_t octets_[Limits::datagram_octets + small_datagrams_octets];
};

}  // namespace romano::client
