#include "experiments/operator/message_text.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "experiments/operator/loop_message_text.h"
#include "experiments/operator/movements.h"
#include "romano/message/romano_id.h"
#include "romano/server/server.h"

namespace romano::experiments {
namespace {

using Json = nlohmann::ordered_json;

bool is_topic_of_romano(std::string_view topic) {
    return topic == server::init_topic || topic == server::common_topic ||
           message::RomanoId::is_id(topic);
}

std::int32_t signed_at(Bytes octets, std::size_t at) {
    return static_cast<std::int32_t>(std::uint32_t{be16(octets, at)} << 16U | be16(octets, at + 2));
}

std::string type_number(unsigned type) {
    const std::array<std::uint8_t, 2> octets = {static_cast<std::uint8_t>(type >> 8U),
                                                static_cast<std::uint8_t>(type)};
    return "0x" + hexadecimal(octets);
}

void add_content(Json& to, const char* text_key, Bytes octets) {
    if (is_text(octets)) {
        to[text_key] = as_text(octets);
    } else {
        to["octets"] = hexadecimal(octets);
    }
}

Json sensor_json(const message::SensorData& data) {
    using message::SensorType;
    const Bytes value = data.value;
    Json out{{"type", "sensor-data"}};
    switch (data.type) {
        case SensorType::gyroscope:
            out["sensor"] = "gyroscope";
            out["mdeg_per_s"] = {signed_at(value, 0), signed_at(value, 4), signed_at(value, 8)};
            return out;
        case SensorType::proximity:
            out["sensor"] = "proximity";
            out["mm"] = static_cast<std::uint32_t>(signed_at(value, 0));
            return out;
        case SensorType::location:
            out["sensor"] = "location";
            out["x_mm"] = signed_at(value, 0);
            out["y_mm"] = signed_at(value, 4);
            out["heading_mdeg"] = signed_at(value, 8);
            return out;
        case SensorType::speed:
            out["sensor"] = "speed";
            out["mm_per_s"] = signed_at(value, 0);
            out["mdeg_per_s"] = signed_at(value, 4);
            return out;
        case SensorType::battery:
            out["sensor"] = "battery";
            out["mv"] = be16(value, 0);
            return out;
        case SensorType::line_reflectance:
            out["sensor"] = "line-reflectance";
            for (std::size_t at = 0; at < 10; at += 2) out["values"].push_back(be16(value, at));
            return out;
        case SensorType::first_of_application:
            break;
    }
    out["sensor"] = type_number(static_cast<unsigned>(data.type));
    out["octets"] = hexadecimal(value);
    return out;
}

Json movement_json(const message::MovementControl& movement) {
    const auto type = static_cast<std::size_t>(movement.type);
    Json out{{"type", "movement-control"}};
    if (const auto amount = message::amount_of(movement)) {
        out["movement"] = movements.at(type);
        out[type < 4 ? "mm" : "mdeg"] = *amount;
    } else {
        out["movement"] = type_number(static_cast<unsigned>(type));
        out["octets"] = hexadecimal(movement.arguments);
    }
    return out;
}

/// Empty when it belongs to no control loop: those have a type of the application's own.
std::optional<Json> loop_json(const message::ApplicationData& m) {
    if (m.type != control::data_type || m.data.size() + 2 > control::largest_message) return {};
    std::vector<std::uint8_t> octets{m.type, static_cast<std::uint8_t>(m.data.size() + 2)};
    octets.insert(octets.end(), m.data.begin(), m.data.end());
    const auto message = control::decode(octets);
    if (!message) return {};
    return to_json(*message);
}

struct Words {
    Json operator()(const message::NormalData& m) const {
        Json out{{"type", "normal-data"}};
        add_content(out, "text", m.data);
        return out;
    }
    Json operator()(const message::MqttSubscribe& m) const {
        return {{"type", "mqtt-subscribe"}, {"topic", m.topic}};
    }
    Json operator()(const message::MqttUnsubscribe& m) const {
        return {{"type", "mqtt-unsubscribe"}, {"topic", m.topic}};
    }
    Json operator()(const message::MqttPublishRequest& m) const {
        Json out{{"type", "mqtt-publish-request"}, {"topic", m.topic}};
        add_content(out, "kind", m.kind_of_data);
        return out;
    }
    Json operator()(const message::ConnectedNodes& m) const {
        Json out{{"type", "connected-nodes"}, {"nodes", Json::array()}};
        for (std::size_t i = 0; i < m.count(); ++i) out["nodes"].push_back(m.at(i).text());
        return out;
    }
    Json operator()(const message::RequestConnectedNodes& m) const {
        return {{"type", "request-connected-nodes"}, {"asker", m.asker.text()}};
    }
    Json operator()(const message::RssiReport& m) const {
        return {{"type", "rssi-report"}, {"heard", m.heard.text()}, {"dbm", m.rssi_dbm}};
    }
    Json operator()(const message::SensorData& m) const { return sensor_json(m); }
    Json operator()(const message::MovementControl& m) const { return movement_json(m); }
    Json operator()(const message::RemoteControl& m) const {
        return {{"type", "remote-control"}, {"octets", hexadecimal(m.data)}};
    }
    Json operator()(const message::Heartbeat& m) const {
        return {{"type", "heartbeat"}, {"sender", m.sender.text()}};
    }
    Json operator()(const message::ConnectionRequest& m) const {
        return {{"type", "connection-request"}, {"sender", m.sender.text()}};
    }
    Json operator()(const message::ConnectionAck&) const { return {{"type", "connection-ack"}}; }
    Json operator()(const message::UdpSendReq&) const { return {{"type", "udp-send-req"}}; }
    Json operator()(const message::UdpSendGo&) const { return {{"type", "udp-send-go"}}; }
    Json operator()(const message::ApplicationData& m) const {
        if (auto of_a_loop = loop_json(m)) return *of_a_loop;
        return {{"type", type_number(m.type)}, {"octets", hexadecimal(m.data)}};
    }
};

std::string printed(const Json& value) {
    return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::optional<message::Message> romano_message(std::string_view topic, Bytes data) {
    const auto message = message::decode(data);
    if (!message) return std::nullopt;
    const bool is_own = std::holds_alternative<message::ApplicationData>(*message);
    if (is_own && !is_topic_of_romano(topic)) return std::nullopt;
    return *message;
}

nlohmann::ordered_json to_json(const message::Message& message) {
    return std::visit(Words{}, message);
}

std::string to_line(const message::Message& message) {
    std::string line;
    const nlohmann::ordered_json object = to_json(message);
    for (const auto& [key, value] : object.items()) {
        if (key == "type") {
            line = value.get<std::string>();
            continue;
        }
        std::string text = printed(value);
        const bool is_one_word = value.is_string() && text.find_first_of(" \\=") == text.npos;
        if (is_one_word && text.size() > 2) text = text.substr(1, text.size() - 2);
        line += " " + key + "=" + text;
    }
    return line;
}

std::string hexadecimal(Bytes octets) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const std::uint8_t octet : octets) {
        text += digits[octet >> 4U];
        text += digits[octet & 0x0FU];
    }
    return text;
}

bool is_text(Bytes octets) {
    const bool has_control = std::ranges::any_of(octets, [](std::uint8_t octet) {
        return (octet < 0x20 && octet != '\t') || octet == 0x7F;
    });
    if (has_control) return false;
    try {
        (void)Json(as_text(octets)).dump();  // strict: it throws for what is no UTF-8
    } catch (const Json::exception&) {
        return false;
    }
    return true;
}

}  // namespace romano::experiments
