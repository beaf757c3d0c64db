// The writers that reach one peer alone: its inbox (reliable, in order) and its tray for QoS 0
// publishes (best-effort). Each broker reads only its own two, so that nobody else's threads are
// busy with them. The topics' names hold the incarnation: a restarted broker starts empty.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "broker/core/log_position.h"
#include "overlay/dds/entity.h"
#include "overlay/dds/sample_writer.h"

namespace romano::dds {

[[nodiscard]] std::string inbox_topic(const broker::LogId& addressee);
[[nodiscard]] std::string forward_topic(const broker::LogId& addressee);
/// Whose inbox that is; nobody's when it is another topic.
[[nodiscard]] std::optional<broker::LogId> addressee_of(std::string_view topic);
[[nodiscard]] Qos inbox_qos();
[[nodiscard]] Qos forward_qos();

struct PeerWriters {
    PeerWriters(const Entity& participant, const broker::LogId& self, const broker::LogId& peer)
        : addressee(peer),
          inbox(participant, inbox_topic(peer), inbox_qos(), self),
          forwards(participant, forward_topic(peer), forward_qos(), self) {}

    broker::LogId addressee;
    SampleWriter inbox;
    SampleWriter forwards;
};

}  // namespace romano::dds
