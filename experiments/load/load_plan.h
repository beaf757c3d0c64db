// What a load consists of: how many publish on how many topics to how many, how fast, for how long.
//
// A stream is one publisher's messages on one topic: publishers take the topics in turn, or, when
// there are fewer topics, share them; subscribers likewise. Sequence numbers count within a stream.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "romano/base/time.h"
#include "romano/mqttsn/types.h"

namespace romano::experiments {

struct LoadPlan {
    std::uint32_t publishers = 1;
    std::uint32_t subscribers = 1;
    std::uint32_t topics = 1;
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;  // of the publishes and the subscriptions
    std::uint32_t payload_octets = 32;
    /// Messages a second, of all publishers together; without it a closed loop.
    std::optional<double> rate_per_s = std::nullopt;
    /// The closed loop: messages that are on their way at the same time. One counts as arrived when
    /// all its subscribers have it and, at QoS 1 and 2, its publisher has its answer.
    std::uint32_t in_flight = 64;
    Duration warm_up{std::chrono::seconds{1}};
    Duration duration{std::chrono::seconds{5}};
    Duration drain{std::chrono::seconds{5}};  // at most, without anything arriving
    std::string topic_prefix = "load";

    static constexpr std::uint32_t least_payload_octets = 20;

    /// Publishers first.
    [[nodiscard]] std::uint32_t clients() const { return publishers + subscribers; }

    [[nodiscard]] std::uint32_t streams() const {
        return topics > publishers ? topics : publishers;
    }
    [[nodiscard]] std::uint32_t publisher_of(std::uint32_t stream) const {
        return stream % publishers;
    }
    [[nodiscard]] std::uint32_t topic_of(std::uint32_t stream) const { return stream % topics; }
    /// How many subscribers a topic has.
    [[nodiscard]] std::uint32_t receivers_of(std::uint32_t topic) const;

    [[nodiscard]] std::string topic_name(std::uint32_t topic) const {
        return topic_prefix + "/" + std::to_string(topic);
    }
    /// What a client publishes on, and what it hears: topic numbers, ascending.
    [[nodiscard]] std::vector<std::uint32_t> published_by(std::uint32_t client) const;
    [[nodiscard]] std::vector<std::uint32_t> heard_by(std::uint32_t client) const;
    /// The most topics that one client has to do with.
    [[nodiscard]] std::uint32_t most_topics_of_a_client() const;
};

}  // namespace romano::experiments
