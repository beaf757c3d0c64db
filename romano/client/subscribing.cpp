// MQTT-SN 1.2 section 6.9: subscribe and unsubscribe.
#include "romano/client/client.h"
#include "romano/mqttsn/topic.h"

namespace romano::client {

using mqttsn::MsgType;

Result<OperationId, Refusal> ClientCore::subscribe(Instant now, const mqttsn::TopicRef& topic,
                                                   mqttsn::Qos qos, Output& out) {
    return request(MsgType::subscribe, topic, {}, {.qos = qos}, {now, out});
}

Result<OperationId, Refusal> ClientCore::unsubscribe(Instant now, const mqttsn::TopicRef& topic,
                                                     Output& out) {
    return request(MsgType::unsubscribe, topic, {}, {}, {now, out});
}

/// A plain name gets an id, which must be kept to tell its messages by; wildcards get none.
void ClientCore::begin_subscribe(const Call& call) {
    const std::string_view name = operations_.front_name();
    const bool gets_id = operations_.front().topic_type() == mqttsn::TopicIdType::normal &&
                         !mqttsn::has_wildcard(name);
    if (gets_id && !topics_.make_room_for(name)) {
        return fail_front(mqttsn::ReturnCode::congestion, call.out);
    }
    send_first(MsgType::subscribe, next_msg_id(), call);
}

}  // namespace romano::client
