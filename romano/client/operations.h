// What the application has asked for and the broker has not yet answered, oldest first.
//
// One exchange is open at a time (MQTT-SN 1.2: 6.5c, 6.6c, 6.9g): that of the front; the others
// wait behind it. Operations lie one behind the other in octets that the owner gives at birth, each
// with a copy of its name and data; the only bound is their sum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/client/events.h"
#include "romano/mqttsn/body.h"
#include "romano/mqttsn/types.h"

namespace romano::client {

struct Operation {
    OperationId id{};
    /// What is asked for: PUBLISH, SUBSCRIBE, UNSUBSCRIBE, REGISTER, WILLTOPICUPD or WILLMSGUPD.
    mqttsn::MsgType request{};
    /// What was sent of it and is not answered yet: the request, a REGISTER on the way to it, or
    /// PUBREL behind it. `nothing` while it waits for its turn.
    mqttsn::MsgType sent = nothing;
    std::uint8_t flags = 0;        // of the request, as on the wire
    bool registered_anew = false;  // after PUBACK 2; a second one ends the operation (6.6e)
    mqttsn::TopicId topic_id{};    // of a PUBLISH that is out
    mqttsn::MsgId msg_id{};        // of what is out
    std::uint16_t name_size =
        0;  // of the topic as SUBSCRIBE has it: a name, or the octets of an id
    std::uint16_t data_size = 0;

    static constexpr mqttsn::MsgType nothing{0xFF};

    [[nodiscard]] mqttsn::Qos qos() const { return mqttsn::qos_in(flags); }
    [[nodiscard]] mqttsn::TopicIdType topic_type() const { return mqttsn::topic_type_in(flags); }
};

class OperationQueue {
public:
    explicit OperationQueue(MutableBytes octets) : octets_(octets) {}

    [[nodiscard]] bool empty() const { return used_ == 0; }

    /// Copies everything. False, and nothing changed, when it does not fit.
    [[nodiscard]] bool push(Operation operation, std::string_view name, Bytes data);

    [[nodiscard]] Operation& front() { return front_; }
    [[nodiscard]] const Operation& front() const { return front_; }
    [[nodiscard]] std::string_view front_name() const;
    [[nodiscard]] Bytes front_data() const;
    void pop();

private:
    void load_front();

    MutableBytes octets_;  // for each: an Operation as it was pushed, its name, its data
    std::size_t used_ = 0;
    Operation front_;  // the first, as it is now
};

}  // namespace romano::client
