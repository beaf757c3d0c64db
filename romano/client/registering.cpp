// MQTT-SN 1.2 section 6.5: topic ids for names, asked for by either side.
#include "romano/client/client.h"

namespace romano::client {

using mqttsn::MsgType;
using mqttsn::ReturnCode;

Result<OperationId, Refusal> ClientCore::register_name(Instant now, std::string_view name,
                                                       Output& out) {
    return request(MsgType::register_, topic_name(name), {}, {}, {now, out});
}

/// Room for the answer is made sure of first: an id that cannot be kept is of no use.
void ClientCore::begin_register(const Call& call) {
    if (!topics_.make_room_for(operations_.front_name())) {
        return fail_front(ReturnCode::congestion, call.out);
    }
    send_first(MsgType::register_, next_msg_id(), call);
}

/// The broker's own REGISTER, before it publishes on a name whose id this client cannot know. Any
/// id is taken, and a new name for a known id replaces the old one.
void ClientCore::on_register(mqttsn::Body& message, Output& out) {
    if (!is_receiving()) return drop();
    if (!mqttsn::is_assignable(message.topic_id)) {
        message.code = ReturnCode::invalid_topic_id;
    } else if (message.rest.empty()) {
        message.code = ReturnCode::not_supported;
    } else if (!topics_.put(message.topic_id, as_text(message.rest), TopicTable::Use::to_receive)) {
        message.code = ReturnCode::congestion;
    }
    out.send(MsgType::regack, message);
}

}  // namespace romano::client
