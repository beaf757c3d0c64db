// MQTT-SN 1.2 section 6.5: topic ids for names, asked for by either side.
#include "romano/client/client.h"

namespace romano::client {

using mqttsn::ReturnCode;

Result<OperationId, Refusal> ClientCore::register_name(Instant now, std::string_view name,
                                                       Output& out) {
    return request(now, {.id = next_operation(), .kind = Operation::Kind::register_name},
                   topic_name(name), {}, out);
}

/// Room for the answer is made sure of first: an id that cannot be kept is of no use.
void ClientCore::begin_register(Instant now, Operation operation, Output& out) {
    if (!topics_.has_room_for(operations_.front_name())) {
        return finish_front(Failed{operation.id, ReturnCode::congestion}, out);
    }
    operation.msg_id = next_msg_id();
    await_answer(now, operation, Operation::Stage::registering);
    send_register(operation, out);
}

void ClientCore::send_register(const Operation& operation, Output& out) {
    send(mqttsn::Register{mqttsn::no_topic_id, operation.msg_id, operations_.front_name()}, out);
}

void ClientCore::on_regack(Instant now, const mqttsn::Regack& message, Output& out) {
    if (!is_awaited(Operation::Stage::registering, message.msg_id)) return drop();
    on_answer(now);
    if (message.return_code != ReturnCode::accepted) {
        return refuse_front(now, message.return_code, out);
    }
    const Operation operation = operations_.front();
    if (!mqttsn::is_assignable(message.topic_id)) {
        finish_front(Failed{operation.id, ReturnCode::invalid_topic_id}, out);
    } else if (!topics_.put(message.topic_id, operations_.front_name())) {
        finish_front(Failed{operation.id, ReturnCode::congestion}, out);
    } else if (operation.kind == Operation::Kind::register_name) {
        finish_front(Registered{operation.id, message.topic_id}, out);
    } else {
        postpone_front(operation);
    }
    carry_on(now, out);
}

/// The broker's own REGISTER, before it publishes on a name whose id this client cannot know. Any
/// id is taken, and a new name for a known id replaces the old one.
void ClientCore::on_register(const mqttsn::Register& message, Output& out) {
    if (!is_receiving()) return drop();
    ReturnCode code = ReturnCode::accepted;
    if (!mqttsn::is_assignable(message.topic_id)) {
        code = ReturnCode::invalid_topic_id;
    } else if (message.topic_name.empty()) {
        code = ReturnCode::not_supported;
    } else if (!topics_.put(message.topic_id, message.topic_name)) {
        code = ReturnCode::congestion;
    }
    send(mqttsn::Regack{message.topic_id, message.msg_id, code}, out);
}

}  // namespace romano::client
