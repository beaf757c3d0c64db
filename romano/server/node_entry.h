// What the cluster knows of a ROMANO node: one retained message on `$ROMANO/nodes/<id>` each.
//
// Retained messages are copied to every broker, survive their home and are merged when partitions
// meet, so the list of connected nodes is everyone's without a protocol of its own. The text is for
// people and programs alike:
//
//     form=binary state=connected heartbeat_unix_ms=1790000000123 home=r1 client=abcd1234
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "romano/message/romano_id.h"

namespace romano::server {

inline constexpr std::string_view entries_filter = "$ROMANO/nodes/+";

/// How the node speaks: the paper's messages, or the authors' firmware's ASCII.
enum class Form : std::uint8_t { binary, legacy };

enum class NodeState : std::uint8_t {
    connected,
    silent,  // connected, but its heartbeats are missing: messages to it wait
    away,    // not connected; its session is kept, and so are messages to it
};

struct NodeEntry {
    message::RomanoId id;
    Form form = Form::binary;
    NodeState state = NodeState::connected;
    std::uint64_t heartbeat_unix_ms = 0;  // the last one, to ten seconds; 0: none
    std::string home;                     // the broker's name
    std::string client;                   // the MQTT-SN client id of its session

    friend bool operator==(const NodeEntry&, const NodeEntry&) = default;
};

[[nodiscard]] std::string entry_topic(const message::RomanoId& id);
/// Whose entry is on that topic; empty for any other topic.
[[nodiscard]] std::optional<message::RomanoId> robot_of_entry(std::string_view topic);
[[nodiscard]] std::string to_text(const NodeEntry& entry);
/// Empty when topic and text are no entry.
[[nodiscard]] std::optional<NodeEntry> parse_entry(std::string_view topic, std::string_view text);

[[nodiscard]] std::string_view name_of(Form form);
[[nodiscard]] std::string_view name_of(NodeState state);

}  // namespace romano::server
