// Short words for the messages of the charts.
#pragma once

#include <string_view>

#include "romano/mqttsn/messages.h"

namespace romano::client {

inline constexpr mqttsn::Qos qos_minus1 = mqttsn::Qos::without_connection;
inline constexpr mqttsn::Qos qos0 = mqttsn::Qos::at_most_once;
inline constexpr mqttsn::Qos qos1 = mqttsn::Qos::at_least_once;
inline constexpr mqttsn::Qos qos2 = mqttsn::Qos::exactly_once;

inline mqttsn::Publish publish_of(mqttsn::Qos qos, mqttsn::TopicId id, mqttsn::MsgId msg_id,
                                  std::string_view data) {
    return {false, qos, false, mqttsn::TopicIdType::normal, id, msg_id, as_octets(data)};
}

inline mqttsn::Publish again(mqttsn::Publish message) {
    message.dup = true;
    return message;
}

inline mqttsn::Subscribe subscribe_of(std::string_view name, mqttsn::Qos qos,
                                      mqttsn::MsgId msg_id) {
    return {false, qos, msg_id, {mqttsn::TopicIdType::normal, name, mqttsn::no_topic_id}};
}

inline mqttsn::Register register_of(std::string_view name, mqttsn::MsgId msg_id) {
    return {mqttsn::no_topic_id, msg_id, name};
}

}  // namespace romano::client
