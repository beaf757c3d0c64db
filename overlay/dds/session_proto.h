// Messages and session images as Protobuf: broker/core/message.h and session_image.h.
#pragma once

#include <optional>

#include "broker/core/session_image.h"
#include "overlay/dds/place_proto.h"

namespace romano::overlay::proto {

void to_proto(const broker::MessagePtr& in, Message& out);  // in is not null
[[nodiscard]] std::optional<broker::MessagePtr> from_proto(const Message& in);

void to_proto(const broker::SessionHeader& in, SessionHeader& out);
[[nodiscard]] std::optional<broker::SessionHeader> from_proto(const SessionHeader& in);

void to_proto(const broker::Will& in, Will& out);
[[nodiscard]] std::optional<broker::Will> from_proto(const Will& in);

void to_proto(const broker::Subscription& in, Subscription& out);
[[nodiscard]] std::optional<broker::Subscription> from_proto(const Subscription& in);

void to_proto(const broker::TopicBinding& in, TopicBinding& out);
[[nodiscard]] std::optional<broker::TopicBinding> from_proto(const TopicBinding& in);

void to_proto(const broker::Delivery& in, Delivery& out);
[[nodiscard]] std::optional<broker::Delivery> from_proto(const Delivery& in);

void to_proto(const broker::SessionImage& in, SessionImage& out);
[[nodiscard]] std::optional<broker::SessionImage> from_proto(const SessionImage& in);

/// A QoS as messages and subscriptions have it: 0, 1 or 2.
[[nodiscard]] std::optional<mqttsn::Qos> qos_from(std::uint32_t value);

}  // namespace romano::overlay::proto
