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
    void text(std::string_view value) { octets(as_octets(value)); }

    [[nodiscard]] std::size_t finish() {
        if (overflow_) return 0;
        out_[1] = static_cast<std::uint8_t>(size_);
        return size_;
    }

private:
    MutableBytes out_;
    std::size_t size_ = 0;
    bool overflow_ = false;
};

struct Encoder {
    MutableBytes out;

    [[nodiscard]] std::size_t plain(DataType type, Bytes data) const {
        Writer writer(type, out);
        writer.octets(data);
        return writer.finish();
    }
    [[nodiscard]] std::size_t id(DataType type, const RomanoId& id) const {
        return plain(type, as_octets(id.text()));
    }

    std::size_t operator()(const NormalData& m) const {
        return plain(DataType::normal_data, m.data);
    }
    std::size_t operator()(const MqttSubscribe& m) const {
        return plain(DataType::mqtt_subscribe, as_octets(m.topic));
    }
    std::size_t operator()(const MqttUnsubscribe& m) const {
        return plain(DataType::mqtt_unsubscribe, as_octets(m.topic));
    }
    std::size_t operator()(const MqttPublishRequest& m) const {
        if (m.topic.size() > max_message) return 0;
        Writer writer(DataType::mqtt_publish_request, out);
        writer.octet(static_cast<std::uint8_t>(header_size + m.topic.size()));
        writer.text(m.topic);
        writer.octets(m.kind_of_data);
        return writer.finish();
    }
    std::size_t operator()(const ConnectedNodes& m) const {
        return plain(DataType::connected_nodes, m.ids);
    }
    std::size_t operator()(const RequestConnectedNodes& m) const {
        return id(DataType::request_connected_nodes, m.asker);
    }
    std::size_t operator()(const RssiReport& m) const {
        Writer writer(DataType::rssi_report, out);
        writer.text(m.heard.text());
        writer.octet(static_cast<std::uint8_t>(m.rssi_dbm));
        return writer.finish();
    }
    std::size_t operator()(const SensorData& m) const {
        Writer writer(DataType::sensor_data, out);
        writer.number16(static_cast<std::uint16_t>(m.type));
        writer.octets(m.value);
        return writer.finish();
    }
    std::size_t operator()(const MovementControl& m) const {
        Writer writer(DataType::movement_control, out);
        writer.number16(static_cast<std::uint16_t>(m.type));
        writer.octets(m.arguments);
        return writer.finish();
    }
    std::size_t operator()(const RemoteControl& m) const {
        return plain(DataType::remote_control, m.data);
    }
    std::size_t operator()(const Heartbeat& m) const { return id(DataType::heartbeat, m.sender); }
    std::size_t operator()(const ConnectionRequest& m) const {
        return id(DataType::connection_request, m.sender);
    }
    std::size_t operator()(const ConnectionAck&) const {
        return plain(DataType::connection_ack, {});
    }
    std::size_t operator()(const UdpSendReq&) const { return plain(DataType::udp_send_req, {}); }
    std::size_t operator()(const UdpSendGo&) const { return plain(DataType::udp_send_go, {}); }
    std::size_t operator()(const ApplicationData& m) const {
        if (m.type < static_cast<std::uint8_t>(DataType::first_of_application)) return 0;
        return plain(static_cast<DataType>(m.type), m.data);
    }
};

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

std::size_t encode(const Message& message, MutableBytes out) {
    const std::size_t size = std::visit(Encoder{out}, message);
    return size != 0 && decode(out.first(size)).has_value() ? size : 0;
}

std::optional<std::uint32_t> amount_of(const MovementControl& movement) {
    if (movement.type > MovementType::rotate_right || movement.arguments.size() != 4)
        return std::nullopt;
    return (std::uint32_t{be16(movement.arguments, 0)} << 16U) | be16(movement.arguments, 2);
}

}  // namespace romano::message
