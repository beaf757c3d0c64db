// MQTT-SN 1.2 section 6.4: the will changes while connected. The answers carry no message id.
#include "romano/client/client.h"

namespace romano::client {

Result<OperationId, Refusal> ClientCore::update_will_topic(Instant now, std::string_view topic,
                                                           const PublishOptions& options,
                                                           Output& out) {
    return enqueue(
        {.kind = Operation::Kind::will_topic, .qos = options.qos, .retain = options.retain}, topic,
        {}, {now, out});
}

Result<OperationId, Refusal> ClientCore::update_will_message(Instant now, Bytes message,
                                                             Output& out) {
    return enqueue({.kind = Operation::Kind::will_message}, {}, message, {now, out});
}

void ClientCore::on_will_response(Operation::Kind kind, mqttsn::ReturnCode code, const Call& call) {
    const bool awaited = is_awaited(kind, Operation::Stage::requested, mqttsn::no_msg_id);
    if (!is_accepted(awaited, code, call)) return;
    finish_front(WillUpdated{operations_.front().id}, call.out);
}

}  // namespace romano::client
