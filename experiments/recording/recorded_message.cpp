#include "experiments/recording/recorded_message.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <variant>
#include <vector>

#include "experiments/operator/message_text.h"
#include "romano/message/romano_id.h"
#include "romano/server/server.h"

namespace romano::experiments {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

/// Flat, and with one type a property: what readers of JSON Schema all understand.
constexpr std::string_view schema_text = R"({
  "$schema": "http://json-schema.org/draft-07/schema#",
  "title": "romano.Published",
  "description": "A message that went over a ROMANO broker. The channel's topic is its topic.",
  "type": "object",
  "properties": {
    "qos": {"type": "integer", "description": "0, 1 or 2: as it reached the recorder"},
    "retain": {"type": "boolean", "description": "the broker kept it from before the recording"},
    "text": {"type": "string", "description": "the payload, when it is UTF-8"},
    "octets": {"type": "string", "description": "the payload in hexadecimal, when it is no UTF-8"},
    "json": {"type": "object", "description": "what the text says, when it is JSON"},
    "romano": {
      "type": "object",
      "description": "what the payload says, when it is a ROMANO message; fields that its type has",
      "properties": {
        "type": {"type": "string", "description": "sensor-data, movement-control, heartbeat..."},
        "sensor": {"type": "string"},
        "x_mm": {"type": "integer"},
        "y_mm": {"type": "integer"},
        "heading_mdeg": {"type": "integer", "description": "thousandths of a degree"},
        "mm_per_s": {"type": "integer"},
        "mm": {"type": "integer", "description": "of a movement, or to what is near"},
        "mdeg": {"type": "integer", "description": "of a rotation"},
        "mv": {"type": "integer", "description": "of the battery, in millivolts"},
        "movement": {"type": "string"},
        "sender": {"type": "string", "description": "a robot's id"},
        "topic": {"type": "string"},
        "dbm": {"type": "integer"}
      }
    },
    "is_linked": {"type": "boolean", "description": "of the recorder alone: a broker answers it"},
    "broker": {"type": "string", "description": "of the recorder alone: the broker that it asks"}
  }
}
)";

std::optional<std::string> octets_of(const std::string& hexadecimal_text) {
    const auto digit = [](char c) {
        constexpr std::string_view digits = "0123456789abcdef";
        return digits.find(c);
    };
    if (hexadecimal_text.size() % 2 != 0) return std::nullopt;
    std::string out;
    out.reserve(hexadecimal_text.size() / 2);
    for (std::size_t at = 0; at < hexadecimal_text.size(); at += 2) {
        const std::size_t high = digit(hexadecimal_text[at]);
        const std::size_t low = digit(hexadecimal_text[at + 1]);
        if (high == std::string::npos || low == std::string::npos) return std::nullopt;
        out += static_cast<char>(high << 4U | low);
    }
    return out;
}

struct AsksForSomething {
    template <typename Other>
    bool operator()(const Other&) const {
        return true;
    }
    bool operator()(const message::NormalData&) const { return false; }
    bool operator()(const message::SensorData&) const { return false; }
    bool operator()(const message::RssiReport&) const { return false; }
};

}  // namespace

mcap::Schema recording_schema() {
    return {.id = 1,
            .name = "romano.Published",
            .encoding = "jsonschema",
            .data = std::string{schema_text}};
}

RecordedTopic recorded_topic(const mqttsn::TopicRef& topic) {
    switch (topic.type) {
        case mqttsn::TopicIdType::predefined:
            return {"predefined", std::to_string(static_cast<unsigned>(topic.id))};
        case mqttsn::TopicIdType::short_name:
            return {"short", std::string{topic.name}};
        default:
            return {"name", std::string{topic.name}};
    }
}

std::string recorded_text(std::string_view topic, Bytes data, mqttsn::Qos qos, bool retain) {
    ordered_json object{{"qos", static_cast<int>(qos)}, {"retain", retain}};
    if (const auto romano = romano_message(topic, data)) object["romano"] = to_json(*romano);
    std::string text = object.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
    text.pop_back();  // the brace: the payload follows, which may be long
    try {
        text += R"(,"text":)" + json(as_text(data)).dump();  // throws for what is no UTF-8
        if (json::accept(as_text(data))) text.append(R"(,"json":)").append(as_text(data));
    } catch (const json::exception&) {
        text += R"(,"octets":")" + hexadecimal(data) + '"';
    }
    return text + '}';
}

std::string recorded_link(bool is_linked, std::string_view broker) {
    return json{{"is_linked", is_linked}, {"broker", broker}}.dump(-1, ' ', false,
                                                                   json::error_handler_t::replace);
}

std::optional<RecordedMessage> recorded_message(const mcap::Channel& channel, Bytes text) {
    RecordedMessage out;
    out.kind = channel.metadata_of("topic_type");
    out.topic = channel.topic;
    if (out.kind.empty() || channel.message_encoding != recording_encoding) return std::nullopt;
    // The payload once more, as JSON, may be anything: it is passed over, and not built.
    const json object = json::parse(
        as_text(text),
        [](int depth, json::parse_event_t event, json& parsed) {
            if (event != json::parse_event_t::key || depth != 1) return true;
            return parsed != "json" && parsed != "romano";
        },
        false);
    if (!object.is_object()) return std::nullopt;
    if (out.kind == recorder_kind) {
        const auto link = object.find("is_linked");
        if (link == object.end() || !link->is_boolean()) return std::nullopt;
        out.is_linked = link->get<bool>();
        return out;
    }
    const auto qos = object.find("qos");
    const auto retain = object.find("retain");
    if (qos == object.end() || !qos->is_number_unsigned() || qos->get<std::uint64_t>() > 2 ||
        retain == object.end() || !retain->is_boolean()) {
        return std::nullopt;
    }
    out.qos = static_cast<mqttsn::Qos>(qos->get<unsigned>());
    out.retain = retain->get<bool>();
    if (const auto words = object.find("text"); words != object.end() && words->is_string()) {
        out.data = words->get<std::string>();
        return out;
    }
    const auto octets = object.find("octets");
    if (octets == object.end() || !octets->is_string()) return std::nullopt;
    auto data = octets_of(octets->get<std::string>());
    if (!data) return std::nullopt;
    out.data = std::move(*data);
    return out;
}

bool is_heeded(std::string_view topic, Bytes data) {
    if (std::ranges::count(server::observed_topics, topic) > 0) return true;
    if (message::RomanoId::is_id(topic)) return true;
    const auto message = romano_message(topic, data);
    return message && std::visit(AsksForSomething{}, *message);
}

}  // namespace romano::experiments
