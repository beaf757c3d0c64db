// A message as it stands in a recording: a JSON object on a channel that has its topic's name, so
// that every reader of MCAP shows what is in it; and exactly what was published, so that it can be
// published again. README.md has the keys.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "experiments/mcap/records.h"
#include "romano/base/bytes.h"
#include "romano/client/events.h"
#include "romano/mqttsn/types.h"

namespace romano::experiments {

inline constexpr std::string_view recording_encoding = "json";
/// Of all channels.
[[nodiscard]] mcap::Schema recording_schema();

/// The recorder's own word on whether a broker answers it: kind `recorder_kind`, on this topic.
inline constexpr std::string_view recorder_kind = "recorder";
inline constexpr std::string_view recorder_topic = "romano-record";

/// How a topic is named on the wire: "name", "short" or "predefined"; then `topic` is the id's
/// digits.
struct RecordedTopic {
    std::string_view kind;
    std::string topic;
};
[[nodiscard]] RecordedTopic recorded_topic(const mqttsn::TopicRef& topic);

/// The JSON text for it.
[[nodiscard]] std::string recorded_text(std::string_view topic, Bytes data, mqttsn::Qos qos,
                                        bool retain);
[[nodiscard]] std::string recorded_link(bool is_linked, std::string_view broker);

struct RecordedMessage {
    std::string_view kind;  // in the channel
    std::string_view topic;
    std::string data;
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;
    bool retain = false;
    bool is_linked = false;  // of the recorder's own word
};

/// Empty when the channel or the message is not as this program records.
[[nodiscard]] std::optional<RecordedMessage> recorded_message(const mcap::Channel& channel,
                                                              Bytes text);

/// Robots or brokers heed it: it is on a topic where robots are told something or tell brokers that
/// they are there, or it is a ROMANO message that asks something of its receiver.
[[nodiscard]] bool is_heeded(std::string_view topic, Bytes data);

}  // namespace romano::experiments
