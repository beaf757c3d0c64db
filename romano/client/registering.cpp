// MQTT-SN 1.2 section 6.5: topic ids for names, asked for by either side.
#include "romano/client/client.h"

namespace romano::client {

using mqttsn::ReturnCode;

Result<OperationId, Refusal> ClientCore::register_name(Instant now, std::string_view name,
                                                       Output& out) {
    return request({.kind = Operation::Kind::register_name}, topic_name(name), {}, {now, out});
}

/// Room for the answer is made sure of first: an id that cannot be kept is of no use.
void ClientCore::begin_register(const Call& call) {
    if (!topics_.has_room_for(operations_.front_name())) {
        return fail_front(ReturnCode::congestion, call.out);
    }
    send_first(Operation::Stage::registering, next_msg_id(), call);
}

void ClientCore::on_regack(const mqttsn::Regack& message, const Call& call) {
    const bool awaited = is_awaited(Operation::Stage::registering, message.msg_id);
    if (!is_accepted(awaited, message.return_code, call)) return;
    const Operation& operation = operations_.front();
    if (!mqttsn::is_assignable(message.topic_id)) {
        fail_front(ReturnCode::invalid_topic_id, call.out);
    } else if (!topics_.put(message.topic_id, operations_.front_name())) {
        fail_front(ReturnCode::congestion, call.out);
    } else if (operation.kind == Operation::Kind::register_name) {
        finish_front(Registered{operation.id, message.topic_id}, call.out);
    } else {
        postpone_front();
    }
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
