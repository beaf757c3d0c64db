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
#include "romano/mqttsn/messages.h"
#include "romano/mqttsn/types.h"

namespace romano::client {

struct Operation {
    enum class Kind : std::uint8_t {
        publish,
        subscribe,
        unsubscribe,
        register_name,
        will_topic,
        will_message
    };
    /// How far the front has come. The others are `waiting`.
    enum class Stage : std::uint8_t {
        waiting,
        registering,  // REGISTER sent: on the way to a topic id for a publish, or for its own sake
        requested,    // PUBLISH, SUBSCRIBE, UNSUBSCRIBE or WILL...UPD sent
        releasing,    // PUBREL sent, section 6.6 at QoS 2
    };

    OperationId id{};
    Kind kind{};
    Stage stage = Stage::waiting;
    mqttsn::Qos qos{};
    bool retain = false;
    bool registered_anew = false;  // after PUBACK 2; a second one ends the operation (6.6e)
    mqttsn::TopicIdType topic_type{};
    mqttsn::TopicId topic_id{};  // predefined
    mqttsn::MsgId msg_id{};      // of the request that is out
    std::uint16_t name_size = 0;
    std::uint16_t data_size = 0;
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
