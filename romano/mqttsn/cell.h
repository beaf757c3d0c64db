// PUBLISH to a cell: one datagram to a multicast group, for those of a broker's clients that said
// that they listen there. What it means, and why so: romano/mqttsn/cell.md.
//
// It has the fields of MQTT-SN 1.2 section 5.4.12 with topic id type 0b11, which 1.2 reserves:
//
//     flags     QoS 0 or 1, topic id type 0b11; the others 0
//     TopicId   high octet: answers are spread over so many steps of 10 ms; low octet: name's size
//     MsgId     0x0000 at QoS 0
//     Data      u8 n, n listener numbers (u16 each) of whom it is not for, at QoS 1 the MsgId (u16)
//               that a listener must have taken last, or 0x0000, topic name, payload
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/base/fnv1a.h"
#include "romano/base/time.h"
#include "romano/mqttsn/body.h"
#include "romano/mqttsn/types.h"

namespace romano::mqttsn {

/// Who subscribes to this name says that it listens to the cell. Nothing is ever published there.
inline constexpr std::string_view cell_topic = "$cell";

inline constexpr std::chrono::milliseconds cell_answer_step{10};
inline constexpr std::size_t most_cell_name = 255;
/// More of them, and the message is not for the cell.
inline constexpr std::size_t most_cell_exceptions = 16;

/// By which a cell's datagram names a client: FNV-1a of its id, folded. Two clients may share one.
constexpr std::uint16_t listener_number(std::string_view client_id) {
    const auto hash = fnv1a<std::uint32_t>(client_id);
    return static_cast<std::uint16_t>(hash >> 16U ^ hash);
}

/// When a listener answers: so long after the message, each at its own time in the spread.
constexpr Duration cell_answer_delay(unsigned steps, std::uint16_t listener) {
    const auto spread = static_cast<std::uint32_t>(cell_answer_step.count()) * steps;
    return to_duration(std::chrono::milliseconds{spread * listener >> 16U});
}

/// Views of the datagram.
struct CellPublish {
    unsigned answer_steps;
    Bytes exceptions;  // two octets each
    MsgId behind;      // who did not take that one last does not take this one; none: at QoS 0, too
    std::string_view name;
    Bytes payload;

    [[nodiscard]] constexpr bool is_for(std::uint16_t listener) const {
        for (std::size_t at = 0; at < exceptions.size(); at += 2) {
            if (be16(exceptions, at) == listener) return false;
        }
        return true;
    }
};

/// Nothing when the body of that PUBLISH is no cell's.
[[nodiscard]] inline std::optional<CellPublish> read_cell_publish(const Body& publish) {
    if (topic_type_in(publish.flags) != TopicIdType::reserved || publish.rest.empty()) return {};
    if (qos_in(publish.flags) > Qos::at_least_once) return {};
    const auto sizes = static_cast<unsigned>(publish.topic_id);
    const std::size_t exceptions = 2U * publish.rest[0];
    const std::size_t name = sizes & 0xFFU;
    const bool is_answered = qos_in(publish.flags) == Qos::at_least_once;
    const std::size_t name_at = 1 + exceptions + (is_answered ? 2U : 0U);
    if (name == 0 || publish.rest.size() < name_at + name) return {};
    return CellPublish{.answer_steps = sizes >> 8U,
                       .exceptions = publish.rest.subspan(1, exceptions),
                       .behind = is_answered ? MsgId{be16(publish.rest, name_at - 2)} : no_msg_id,
                       .name = as_text(publish.rest.subspan(name_at, name)),
                       .payload = publish.rest.subspan(name_at + name)};
}

/// What stands in TopicId. The name has most_cell_name octets at most.
[[nodiscard]] constexpr TopicId cell_sizes(unsigned answer_steps, std::string_view name) {
    return TopicId{
        static_cast<std::uint16_t>(std::min(answer_steps, 255U) << 8U | (name.size() & 0xFFU))};
}

}  // namespace romano::mqttsn
