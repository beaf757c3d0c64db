// MQTT-SN 1.2 section 6.4: the will changes while connected. The answers carry no message id.
#include "romano/client/client.h"

namespace romano::client {

Result<OperationId, Refusal> ClientCore::update_will_topic(Instant now, std::string_view topic,
                                                           const PublishOptions& options,
                                                           Output& out) {
    return enqueue(now,
                   {.id = next_operation(),
                    .kind = Operation::Kind::will_topic,
                    .qos = options.qos,
                    .retain = options.retain},
                   topic, {}, out);
}

Result<OperationId, Refusal> ClientCore::update_will_message(Instant now, Bytes message,
                                                             Output& out) {
    return enqueue(now, {.id = next_operation(), .kind = Operation::Kind::will_message}, {},
                   message, out);
}

void ClientCore::begin_will_update(Instant now, Operation operation, Output& out) {
    await_answer(now, operation, Operation::Stage::requested);
    send_will_update(operation, out);
}

void ClientCore::send_will_update(const Operation& operation, Output& out) {
    if (operation.kind == Operation::Kind::will_topic) {
        send(mqttsn::Willtopicupd{operation.qos, operation.retain, operations_.front_name()}, out);
    } else {
        send(mqttsn::Willmsgupd{operations_.front_data()}, out);
    }
}

void ClientCore::on_will_response(Instant now, Operation::Kind kind, mqttsn::ReturnCode code,
                                  Output& out) {
    if (!is_awaited(kind, Operation::Stage::requested, mqttsn::no_msg_id)) return drop();
    on_answer(now);
    if (code != mqttsn::ReturnCode::accepted) return refuse_front(now, code, out);
    finish_front(WillUpdated{operations_.front().id}, out);
    carry_on(now, out);
}

}  // namespace romano::client
