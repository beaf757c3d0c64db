// One datagram for many: a PUBLISH of QoS 0 or 1 goes once to a multicast group
// (BrokerOptions::cell_group) for those clients of a service address that said that they listen
// there (mqttsn/cell.h; why so: romano/mqttsn/cell.md).
//
// For a listener nothing is different: its message is at the front of its queue, and an exchange is
// open about it whose first sending was the cell's. So the log, a mirror and another home know
// what they know of a unicast, and what is not answered follows as one, with DUP. Of a burst the
// next messages wait behind the front, with the ids under which the cell was told them (Begun).
//
// A listener hears every datagram of its cell. It takes what has a name that it knows and does not
// except it; so all are excepted that have an id for that name and are not to take the datagram
// now: who is busy or asleep, comes next by its queue, was lost, or only publishes there.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "broker/core/delivery_flow.h"
#include "broker/core/outbox.h"
#include "broker/core/receiver.h"
#include "broker/core/tables.h"
#include "romano/base/bytes.h"

namespace romano::broker {

/// Its client can hear a cell, and knows the id by which it is named there. What is protected or
/// comes by a forwarder never does.
[[nodiscard]] bool can_listen(const Session& session);

class Cell {
public:
    Cell(Tables& tables, DeliveryFlow& deliveries) : tables_(tables), deliveries_(deliveries) {}

    /// Something is sent to the cell at all, and messages like this one may be.
    [[nodiscard]] bool takes(std::string_view topic, mqttsn::Qos qos) const;

    /// Serves those receivers that one datagram a service address can serve, and marks them.
    /// `message`: at QoS 1.
    void deliver(std::string_view topic, Bytes payload, mqttsn::Qos qos, const MessagePtr& message,
                 std::span<Receiver> receivers, Turn& turn);

private:
    /// By session number: those of a plain filter are visited so, and before all others.
    using Members = std::vector<Receiver*>;

    [[nodiscard]] bool is_member(const Receiver& receiver, std::string_view topic,
                                 mqttsn::Qos qos) const;
    /// Fills exceptions_. False when the message must not go to the cell: a listener may not read
    /// it, or too many are excepted.
    [[nodiscard]] bool find_exceptions(const Endpoint& via, std::string_view topic,
                                       const Members& members);
    void send(Members& members, mqttsn::MsgId behind, std::string_view topic, Bytes payload,
              mqttsn::Qos qos, const MessagePtr& message, Turn& turn);
    /// The last message that they have not all answered yet; none: they have. Whoever was told
    /// another one last is no member any more.
    [[nodiscard]] static mqttsn::MsgId unanswered(Members& members);
    [[nodiscard]] static std::uint16_t latest_msg_id(const Members& members);

    Tables& tables_;
    DeliveryFlow& deliveries_;
    // Kept for their room, from message to message.
    Members waiting_;
    Members members_;
    std::vector<std::uint16_t> exceptions_;  // listener numbers, sorted
    std::vector<std::uint8_t> data_;
};

}  // namespace romano::broker
