// Which topics go over the uplink, in which direction, and how they are called on either side. A
// rule is written as a `topic` line of mosquitto's bridges: PATTERN [out|in|both] [QOS]
// [LOCAL-PREFIX] [REMOTE-PREFIX], where "" is no prefix. The first rule that fits counts.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "romano/base/result.h"
#include "romano/mqttsn/types.h"

namespace romano::uplink {

struct TopicRule {
    std::string pattern;
    bool out = true;
    bool in = true;
    mqttsn::Qos most = mqttsn::Qos::exactly_once;
    std::string local_prefix;
    std::string remote_prefix;
};

/// The error says what is allowed instead.
[[nodiscard]] Result<TopicRule, std::string> parse_rule(std::string_view text);

struct Filter {
    std::string filter;
    mqttsn::Qos qos;

    friend bool operator==(const Filter&, const Filter&) = default;
};

/// A message's topic and QoS on the other side.
struct Place {
    std::string topic;
    mqttsn::Qos qos;

    friend bool operator==(const Place&, const Place&) = default;
};

class TopicRules {
public:
    explicit TopicRules(std::vector<TopicRule> rules) : rules_(std::move(rules)) {}

    /// What must be subscribed to here, and at the MQTT broker.
    [[nodiscard]] std::vector<Filter> local_filters() const;
    [[nodiscard]] std::vector<Filter> remote_filters() const;

    /// Empty when it does not go that way. Topics that begin with $ never do.
    [[nodiscard]] std::optional<Place> to_remote(std::string_view topic, mqttsn::Qos qos) const;
    [[nodiscard]] std::optional<Place> to_local(std::string_view topic, mqttsn::Qos qos) const;

private:
    std::vector<TopicRule> rules_;
};

}  // namespace romano::uplink
