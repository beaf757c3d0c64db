#include "romano/message/codec.h"

#include <algorithm>

namespace romano::message {

namespace {

constexpr std::size_t header_size = 2;
constexpr std::size_t any_size = SIZE_MAX;

std::optional<RomanoId> id_at(Bytes octets, std::size_t at) {
    return RomanoId::parse(as_text(octets.subspan(at, RomanoId::size)));
}

/// Size of a sensor's value; any_size for the application's own types, empty for reserved ones.
std::optional<std::size_t> sensor_value_size(SensorType type) {
    switch (type) {
        case SensorType::gyroscope:
        case SensorType::location:
            return 12;
        case SensorType::proximity:
            return 4;
        case SensorType::speed:
            return 8;
        case SensorType::battery:
            return 2;
        case SensorType::line_reflectance:
            return 10;
        default:
            if (type >= SensorType::first_of_application) return any_size;
            return std::nullopt;
    }
}

/// As sensor_value_size, for a movement's arguments.
std::optional<std::size_t> movement_arguments_size(MovementType type) {
    if (type <= MovementType::rotate_right) return 4;
    if (type >= MovementType::first_of_application) return any_size;
    return std::nullopt;
}

using Decoded = Result<Message, Malformed>;

template <typename WithId>
Decoded decode_id(Bytes body) {
    if (body.size() != RomanoId::size) return Malformed::size;
    const auto id = id_at(body, 0);
    if (!id) return Malformed::value;
    return Message{WithId{*id}};
}

template <typename WithTopic>
Decoded decode_topic(Bytes body) {
    if (body.empty()) return Malformed::size;
    return Message{WithTopic{as_text(body)}};
}

template <typename Empty>
Decoded decode_empty(Bytes body) {
    if (!body.empty()) return Malformed::size;
    return Message{Empty{}};
}

/// Octet 2 of the message holds the index of the topic's last octet, counted from the message's
/// begin.
Decoded decode_publish_request(Bytes body) {
    constexpr std::size_t topic_at = header_size + 1;
    if (body.size() < 2) return Malformed::size;
    const std::size_t last = body[0];
    if (last < topic_at || last >= body.size() + header_size) return Malformed::value;
    const std::size_t topic_size = last - topic_at + 1;
    return Message{
        MqttPublishRequest{as_text(body.subspan(1, topic_size)), body.subspan(1 + topic_size)}};
}

Decoded decode_connected_nodes(Bytes body) {
    if (body.size() % RomanoId::size != 0) return Malformed::size;
    for (std::size_t at = 0; at < body.size(); at += RomanoId::size) {
        if (!id_at(body, at)) return Malformed::value;
    }
    return Message{ConnectedNodes{body}};
}

Decoded decode_rssi(Bytes body) {
    if (body.size() != RomanoId::size + 1) return Malformed::size;
    const auto id = id_at(body, 0);
    if (!id) return Malformed::value;
    return Message{RssiReport{*id, static_cast<std::int8_t>(body[RomanoId::size])}};
}

template <typename Typed, typename Type>
Decoded decode_typed(Bytes body, std::optional<std::size_t> (*size_of)(Type)) {
    if (body.size() < 2) return Malformed::size;
    const Type type{be16(body, 0)};
    const auto expected = size_of(type);
    if (!expected) return Malformed::value;
    const Bytes rest = body.subspan(2);
    if (*expected != any_size && rest.size() != *expected) return Malformed::size;
    return Message{Typed{type, rest}};
}

/// Appends to a message under construction; remembers when something did not fit.
class Writer {
public:
    Writer(DataType type, MutableBytes out) : out_(out.first(std::min(out.size(), max_message))) {
        octet(static_cast<std::uint8_t>(type));
        octet(0);
    }
    void octet(std::uint8_t value) {
        if (size_ < out_.size()) {
            out_[size_] = value;
        } else {
            overflow_ = true;
        }
        ++size_;
    }
    void number16(std::uint16_t value) {
        octet(static_cast<std::uint8_t>(value >> 8U));
        octet(static_cast<std::uint8_t>(value & 0xFFU));
    }
    void octets(Bytes values) {
        for (const std::uint8_t value : values) octet(value);
    }

    [[nodiscard]] Bytes finish() {
        if (overflow_) return {};
        out_[1] = static_cast<std::uint8_t>(size_);
        return out_.first(size_);
    }

private:
    MutableBytes out_;
    std::size_t size_ = 0;
    bool overflow_ = false;
};

/// The size of a written message; 0 when it would not decode again.
std::size_t checked(Bytes written) {
    return !written.empty() && decode(written).has_value() ? written.size() : 0;
}

std::size_t encode_data(DataType type, Bytes data, MutableBytes out) {
    Writer writer(type, out);
    writer.octets(data);
    return checked(writer.finish());
}
std::size_t encode_id(DataType type, const RomanoId& id, MutableBytes out) {
    return encode_data(type, as_octets(id.text()), out);
}
std::size_t encode_typed(DataType type, std::uint16_t inner, Bytes data, MutableBytes out) {
    Writer writer(type, out);
    writer.number16(inner);
    writer.octets(data);
    return checked(writer.finish());
}

}  // namespace

RomanoId ConnectedNodes::at(std::size_t index) const {
    return id_at(ids, index * RomanoId::size).value_or(RomanoId{});
}

Decoded decode(Bytes data) {
    if (data.size() < header_size) return Malformed::header;
    if (data[1] != data.size()) return Malformed::length;
    const Bytes body = data.subspan(header_size);
    switch (static_cast<DataType>(data[0])) {
        case DataType::normal_data:
            return Message{NormalData{body}};
        case DataType::mqtt_subscribe:
            return decode_topic<MqttSubscribe>(body);
        case DataType::mqtt_publish_request:
            return decode_publish_request(body);
        case DataType::connected_nodes:
            return decode_connected_nodes(body);
        case DataType::request_connected_nodes:
            return decode_id<RequestConnectedNodes>(body);
        case DataType::rssi_report:
            return decode_rssi(body);
        case DataType::sensor_data:
            return decode_typed<SensorData, SensorType>(body, sensor_value_size);
        case DataType::movement_control:
            return decode_typed<MovementControl, MovementType>(body, movement_arguments_size);
        case DataType::remote_control:
            return Message{RemoteControl{body}};
        case DataType::mqtt_unsubscribe:
            return decode_topic<MqttUnsubscribe>(body);
        case DataType::heartbeat:
            return decode_id<Heartbeat>(body);
        case DataType::connection_request:
            return decode_id<ConnectionRequest>(body);
        case DataType::connection_ack:
            return decode_empty<ConnectionAck>(body);
        case DataType::udp_send_req:
            return decode_empty<UdpSendReq>(body);
        case DataType::udp_send_go:
            return decode_empty<UdpSendGo>(body);
        default:
            if (data[0] < static_cast<std::uint8_t>(DataType::first_of_application)) {
                return Malformed::reserved_type;
            }
            return Message{ApplicationData{data[0], body}};
    }
}

std::size_t encode(const NormalData& m, MutableBytes out) {
    return encode_data(DataType::normal_data, m.data, out);
}
std::size_t encode(const MqttSubscribe& m, MutableBytes out) {
    return encode_data(DataType::mqtt_subscribe, as_octets(m.topic), out);
}
std::size_t encode(const MqttPublishRequest& m, MutableBytes out) {
    if (m.topic.size() > max_message) return 0;
    Writer writer(DataType::mqtt_publish_request, out);
    writer.octet(static_cast<std::uint8_t>(header_size + m.topic.size()));
    writer.octets(as_octets(m.topic));
    writer.octets(m.kind_of_data);
    return checked(writer.finish());
}
std::size_t encode(const ConnectedNodes& m, MutableBytes out) {
    return encode_data(DataType::connected_nodes, m.ids, out);
}
std::size_t encode(const RequestConnectedNodes& m, MutableBytes out) {
    return encode_id(DataType::request_connected_nodes, m.asker, out);
}
std::size_t encode(const RssiReport& m, MutableBytes out) {
    Writer writer(DataType::rssi_report, out);
    writer.octets(as_octets(m.heard.text()));
    writer.octet(static_cast<std::uint8_t>(m.rssi_dbm));
    return checked(writer.finish());
}
std::size_t encode(const SensorData& m, MutableBytes out) {
    return encode_typed(DataType::sensor_data, static_cast<std::uint16_t>(m.type), m.value, out);
}
std::size_t encode(const MovementControl& m, MutableBytes out) {
    return encode_typed(DataType::movement_control, static_cast<std::uint16_t>(m.type), m.arguments,
                        out);
}
std::size_t encode(const RemoteControl& m, MutableBytes out) {
    return encode_data(DataType::remote_control, m.data, out);
}
std::size_t encode(const MqttUnsubscribe& m, MutableBytes out) {
    return encode_data(DataType::mqtt_unsubscribe, as_octets(m.topic), out);
}
std::size_t encode(const Heartbeat& m, MutableBytes out) {
    return encode_id(DataType::heartbeat, m.sender, out);
}
std::size_t encode(const ConnectionRequest& m, MutableBytes out) {
    return encode_id(DataType::connection_request, m.sender, out);
}
std::size_t encode(const ConnectionAck&, MutableBytes out) {
    return encode_data(DataType::connection_ack, {}, out);
}
std::size_t encode(const UdpSendReq&, MutableBytes out) {
    return encode_data(DataType::udp_send_req, {}, out);
}
std::size_t encode(const UdpSendGo&, MutableBytes out) {
    return encode_data(DataType::udp_send_go, {}, out);
}
std::size_t encode(const ApplicationData& m, MutableBytes out) {
    if (m.type < static_cast<std::uint8_t>(DataType::first_of_application)) return 0;
    return encode_data(static_cast<DataType>(m.type), m.data, out);
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
