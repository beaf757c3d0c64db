// MQTT-SN 1.2 section 6.4: the will changes while connected. The answers carry no message id.
#include "romano/client/client.h"

namespace romano::client {

using mqttsn::MsgType;

Result<OperationId, Refusal> ClientCore::update_will_topic(Instant now, std::string_view topic,
                                                           const PublishOptions& options,
                                                           Output& out) {
    const auto flags = mqttsn::to_wire({.qos = options.qos, .retain = options.retain});
    return enqueue({.request = MsgType::willtopicupd, .flags = flags}, topic, {}, {now, out});
}

Result<OperationId, Refusal> ClientCore::update_will_message(Instant now, Bytes message,
                                                             Output& out) {
    return enqueue({.request = MsgType::willmsgupd}, {}, message, {now, out});
}

}  // namespace romano::client
