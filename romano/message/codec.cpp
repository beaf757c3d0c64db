#include "romano/message/codec.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>

namespace romano::message {

namespace {

constexpr std::size_t header_size = 2;

/// What stands behind the header.
enum class Form : std::uint8_t {
    reserved,
    octets,           // of any number
    nothing,          //
    topic,            // at least one octet
    publish_request,  // see topic_size_of()
    id,               //
    id_and_octet,     //
    ids,              // of any number
    movement,         // a MovementType and its argument
    sensor,           // a SensorType and its value
};

constexpr Form forms[] = {
    Form::octets,  // NORMAL_DATA
    Form::topic,   // MQTT_SUBSCRIBE
    Form::publish_request,
    Form::ids,           // CONNECTED_NODES
    Form::id,            // REQUEST_CONNECTED_NODES
    Form::id_and_octet,  // RSSI_REPORT
    Form::sensor,        // SENSOR_DATA
    Form::movement,      // MOVEMENT_CONTROL
    Form::octets,        // REMOTE_CONTROL
    Form::topic,         // MQTT_UNSUBSCRIBE
    Form::id,            // HEARTBEAT
    Form::id,            // CONNECTION_REQUEST
    Form::nothing,       // CONNECTION_ACK
    Form::reserved,
    Form::reserved,
    Form::reserved,
    Form::reserved,
    Form::nothing,  // UDP_SEND_REQ
    Form::nothing,  // UDP_SEND_GO
};

Form form_of(std::uint8_t type) {
    return type < std::size(forms) ? forms[type] : Form::octets;  // the application's own
}

/// Of the six standard sensor types, octets.
constexpr std::uint8_t sensor_value_sizes[] = {12, 4, 12, 8, 2, 10};
constexpr std::size_t argument_size = 4;  // of each of the six standard movements
constexpr std::size_t standard_types = 6;

std::optional<Malformed> flaw_of_ids(Bytes body, std::size_t size) {
    if (body.size() != size) return Malformed::size;
    for (std::size_t at = 0; at + RomanoId::size <= size; at += RomanoId::size) {
        if (!RomanoId::is_id(as_text(body.subspan(at, RomanoId::size)))) return Malformed::value;
    }
    return std::nullopt;
}

std::optional<Malformed> flaw_of_typed(Bytes body, bool is_sensor) {
    if (body.size() < 2) return Malformed::size;
    const std::size_t type = be16(body, 0);
    if (type >= 0x8000U) return std::nullopt;  // the application's own
    if (type >= standard_types) return Malformed::value;
    const std::size_t size = is_sensor ? sensor_value_sizes[type] : argument_size;
    if (body.size() != 2 + size) return Malformed::size;
    return std::nullopt;
}

/// Octet 2 of the message holds the index of the topic's last octet, counted
/// from the message's begin.
std::size_t topic_size_of(Bytes body) {
    return std::size_t{body[0]} - header_size;
}

std::optional<Malformed> flaw_of_publish_request(Bytes body) {
    if (body.size() < 2) return Malformed::size;
    if (body[0] <= header_size || topic_size_of(body) >= body.size()) return Malformed::value;
    return std::nullopt;
}

RomanoId id_in(Bytes body) {
    return RomanoId::parse(as_text(body.first(RomanoId::size))).value_or(RomanoId{});
}

/// Writes `part` at `size` and returns where the next belongs, also when it is beyond `out`.
std::size_t append(MutableBytes out, std::size_t size, Bytes part) {
    const std::size_t end = size + part.size();
    if (end <= out.size() && !part.empty()) std::memcpy(&out[size], part.data(), part.size());
    return end;
}

/// A message of that type with `head` and `data` behind one another. 0 when it is too long or would
/// not decode again.
std::size_t write(MutableBytes out, DataType type, Bytes head, Bytes data = {}) {
    const std::size_t size = append(out, append(out, header_size, head), data);
    if (size > std::min(out.size(), max_message)) return 0;
    out[0] = static_cast<std::uint8_t>(type);
    out[1] = static_cast<std::uint8_t>(size);
    return flaw_of(out.first(size)) ? 0 : size;
}

std::size_t write_id(MutableBytes out, DataType type, const RomanoId& id) {
    return write(out, type, as_octets(id.text()));
}

std::size_t write_typed(MutableBytes out, DataType type, std::uint16_t inner, Bytes data) {
    std::array<std::uint8_t, 2> number;
    put_be16(number, 0, inner);
    return write(out, type, number, data);
}

}  // namespace

RomanoId ConnectedNodes::at(std::size_t index) const {
    return id_in(ids.subspan(index * RomanoId::size));
}

std::optional<Malformed> flaw_of(Bytes data) {
    if (data.size() < header_size) return Malformed::header;
    if (data[1] != data.size()) return Malformed::length;
    const Bytes body = data.subspan(header_size);
    const Form form = form_of(data[0]);
    switch (form) {
        case Form::reserved:
            return Malformed::reserved_type;
        case Form::octets:
            return std::nullopt;
        case Form::nothing:
            return flaw_of_ids(body, 0);
        case Form::topic:
            if (body.empty()) return Malformed::size;
            return std::nullopt;
        case Form::publish_request:
            return flaw_of_publish_request(body);
        case Form::id:
            return flaw_of_ids(body, RomanoId::size);
        case Form::id_and_octet:
            return flaw_of_ids(body, RomanoId::size + 1);
        case Form::ids:
            return flaw_of_ids(body, body.size() / RomanoId::size * RomanoId::size);
        case Form::movement:
        case Form::sensor:
            return flaw_of_typed(body, form == Form::sensor);
    }
    return std::nullopt;
}

MovementControl movement_in(Bytes message) {
    return {MovementType{be16(message, header_size)}, message.subspan(header_size + 2)};
}

std::string_view topic_in(Bytes message) {
    return as_text(message.subspan(header_size));
}

MqttPublishRequest publish_request_in(Bytes message) {
    const Bytes body = message.subspan(header_size);
    const std::size_t topic_size = topic_size_of(body);
    return {as_text(body.subspan(1, topic_size)), body.subspan(1 + topic_size)};
}

Result<Message, Malformed> decode(Bytes data) {
    if (const auto flaw = flaw_of(data)) return *flaw;
    const Bytes body = data.subspan(header_size);
    switch (static_cast<DataType>(data[0])) {
        case DataType::normal_data:
            return Message{NormalData{body}};
        case DataType::mqtt_subscribe:
            return Message{MqttSubscribe{topic_in(data)}};
        case DataType::mqtt_publish_request:
            return Message{publish_request_in(data)};
        case DataType::connected_nodes:
            return Message{ConnectedNodes{body}};
        case DataType::request_connected_nodes:
            return Message{RequestConnectedNodes{id_in(body)}};
        case DataType::rssi_report:
            return Message{RssiReport{id_in(body), static_cast<std::int8_t>(body[RomanoId::size])}};
        case DataType::sensor_data:
            return Message{SensorData{SensorType{be16(body, 0)}, body.subspan(2)}};
        case DataType::movement_control:
            return Message{movement_in(data)};
        case DataType::remote_control:
            return Message{RemoteControl{body}};
        case DataType::mqtt_unsubscribe:
            return Message{MqttUnsubscribe{topic_in(data)}};
        case DataType::heartbeat:
            return Message{Heartbeat{id_in(body)}};
        case DataType::connection_request:
            return Message{ConnectionRequest{id_in(body)}};
        case DataType::connection_ack:
            return Message{ConnectionAck{}};
        case DataType::udp_send_req:
            return Message{UdpSendReq{}};
        case DataType::udp_send_go:
            return Message{UdpSendGo{}};
        default:
            return Message{ApplicationData{data[0], body}};
    }
}

std::size_t encode(const NormalData& m, MutableBytes out) {
    return write(out, DataType::normal_data, m.data);
}
std::size_t encode(const MqttSubscribe& m, MutableBytes out) {
    return write(out, DataType::mqtt_subscribe, as_octets(m.topic));
}
std::size_t encode(const MqttPublishRequest& m, MutableBytes out) {
    std::array<std::uint8_t, max_message> topic;  // behind the index of its last octet
    if (m.topic.size() >= topic.size()) return 0;
    topic[0] = static_cast<std::uint8_t>(header_size + m.topic.size());
    const std::size_t size = append(topic, 1, as_octets(m.topic));
    return write(out, DataType::mqtt_publish_request, Bytes{topic}.first(size), m.kind_of_data);
}
std::size_t encode(const ConnectedNodes& m, MutableBytes out) {
    return write(out, DataType::connected_nodes, m.ids);
}
std::size_t encode(const RequestConnectedNodes& m, MutableBytes out) {
    return write_id(out, DataType::request_connected_nodes, m.asker);
}
std::size_t encode(const RssiReport& m, MutableBytes out) {
    const auto rssi = static_cast<std::uint8_t>(m.rssi_dbm);
    return write(out, DataType::rssi_report, as_octets(m.heard.text()), {&rssi, 1});
}
std::size_t encode(const SensorData& m, MutableBytes out) {
    return write_typed(out, DataType::sensor_data, static_cast<std::uint16_t>(m.type), m.value);
}
std::size_t encode(const MovementControl& m, MutableBytes out) {
    return write_typed(out, DataType::movement_control, static_cast<std::uint16_t>(m.type),
                       m.arguments);
}
std::size_t encode(const RemoteControl& m, MutableBytes out) {
    return write(out, DataType::remote_control, m.data);
}
std::size_t encode(const MqttUnsubscribe& m, MutableBytes out) {
    return write(out, DataType::mqtt_unsubscribe, as_octets(m.topic));
}
std::size_t encode(const Heartbeat& m, MutableBytes out) {
    return write_id(out, DataType::heartbeat, m.sender);
}
std::size_t encode(const ConnectionRequest& m, MutableBytes out) {
    return write_id(out, DataType::connection_request, m.sender);
}
std::size_t encode(const ConnectionAck&, MutableBytes out) {
    return write(out, DataType::connection_ack, {});
}
std::size_t encode(const UdpSendReq&, MutableBytes out) {
    return write(out, DataType::udp_send_req, {});
}
std::size_t encode(const UdpSendGo&, MutableBytes out) {
    return write(out, DataType::udp_send_go, {});
}
std::size_t encode(const ApplicationData& m, MutableBytes out) {
    if (m.type < static_cast<std::uint8_t>(DataType::first_of_application)) return 0;
    return write(out, static_cast<DataType>(m.type), m.data);
}

std::size_t encode(const Message& message, MutableBytes out) {
    return std::visit([out](const auto& m) { return encode(m, out); }, message);
}

std::optional<std::uint32_t> amount_of(const MovementControl& movement) {
    if (movement.type > MovementType::rotate_right || movement.arguments.size() != 4)
        return std::nullopt;
    return (std::uint32_t{be16(movement.arguments, 0)} << 16U) | be16(movement.arguments, 2);
}

}  // namespace romano::message
