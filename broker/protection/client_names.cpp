#include "broker/protection/client_names.h"

#include "romano/mqttsn/codec.h"
#include "romano/mqttsn/decode.h"

namespace romano::broker {

using mqttsn::MsgType;

std::optional<std::string_view> named_client(const mqttsn::Frame& frame) {
    if (frame.type == MsgType::connect) {
        const auto connect = mqttsn::decode_connect(frame.body);
        if (connect) return connect->client_id;
    } else if (frame.type == MsgType::pingreq) {
        const auto ping = mqttsn::decode_pingreq(frame.body);
        if (ping && !ping->client_id.empty()) return ping->client_id;
    }
    return std::nullopt;
}

bool is_own_name(std::string_view client_id, Bytes message) {
    const auto frame = mqttsn::decode_frame(message);
    if (!frame) return true;
    const auto named = named_client(*frame);
    return !named || *named == client_id;
}

void put_node_id(std::string_view node_id, MutableBytes out) {
    (void)mqttsn::encode(
        mqttsn::Encapsulated{.radius = 0, .wireless_node_id = as_octets(node_id), .message = {}},
        out);
}

void refuse_connect(const Endpoint& via, const ClientAddress& to, Actions& out) {
    const std::size_t wrapping =
        to.wireless_node_id.empty() ? 0 : node_id_octets(to.wireless_node_id);
    const MutableBytes room = out.reserve(wrapping + 8);
    if (wrapping != 0) put_node_id(to.wireless_node_id, room);
    const std::size_t size =
        mqttsn::encode(mqttsn::Connack{mqttsn::ReturnCode::not_supported}, room.subspan(wrapping));
    const std::uint32_t offset = out.commit(wrapping + size);
    out.push(Send{via, to, 0, offset, static_cast<std::uint32_t>(wrapping + size)});
}

}  // namespace romano::broker
