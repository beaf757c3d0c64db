// One decoder a message: the body behind the frame, MQTT-SN 1.2 section 5.4, field by field.
//
// For receivers that want a few messages and not the code of all: decode_frame(), then the decoder
// of the frame's type. decode() in codec.h does both for every type.
#pragma once

#include "romano/base/bytes.h"
#include "romano/mqttsn/frame.h"
#include "romano/mqttsn/messages.h"

namespace romano::mqttsn {

[[nodiscard]] Decoded<Advertise> decode_advertise(Bytes body);
[[nodiscard]] Decoded<Searchgw> decode_searchgw(Bytes body);
[[nodiscard]] Decoded<Gwinfo> decode_gwinfo(Bytes body);
[[nodiscard]] Decoded<Connect> decode_connect(Bytes body);
[[nodiscard]] Decoded<Connack> decode_connack(Bytes body);
[[nodiscard]] Decoded<Willtopicreq> decode_willtopicreq(Bytes body);
[[nodiscard]] Decoded<Willtopic> decode_willtopic(Bytes body);
[[nodiscard]] Decoded<Willmsgreq> decode_willmsgreq(Bytes body);
[[nodiscard]] Decoded<Willmsg> decode_willmsg(Bytes body);
[[nodiscard]] Decoded<Register> decode_register(Bytes body);
[[nodiscard]] Decoded<Regack> decode_regack(Bytes body);
[[nodiscard]] Decoded<Publish> decode_publish(Bytes body);
[[nodiscard]] Decoded<Puback> decode_puback(Bytes body);
[[nodiscard]] Decoded<Pubcomp> decode_pubcomp(Bytes body);
[[nodiscard]] Decoded<Pubrec> decode_pubrec(Bytes body);
[[nodiscard]] Decoded<Pubrel> decode_pubrel(Bytes body);
[[nodiscard]] Decoded<Subscribe> decode_subscribe(Bytes body);
[[nodiscard]] Decoded<Suback> decode_suback(Bytes body);
[[nodiscard]] Decoded<Unsubscribe> decode_unsubscribe(Bytes body);
[[nodiscard]] Decoded<Unsuback> decode_unsuback(Bytes body);
[[nodiscard]] Decoded<Pingreq> decode_pingreq(Bytes body);
[[nodiscard]] Decoded<Pingresp> decode_pingresp(Bytes body);
[[nodiscard]] Decoded<Disconnect> decode_disconnect(Bytes body);
[[nodiscard]] Decoded<Willtopicupd> decode_willtopicupd(Bytes body);
[[nodiscard]] Decoded<Willtopicresp> decode_willtopicresp(Bytes body);
[[nodiscard]] Decoded<Willmsgupd> decode_willmsgupd(Bytes body);
[[nodiscard]] Decoded<Willmsgresp> decode_willmsgresp(Bytes body);
[[nodiscard]] Decoded<Encapsulated> decode_encapsulated(const Frame& frame);

}  // namespace romano::mqttsn
