// What the clients saw: the only evidence on which the promises P2, P3, P5 and P7 are judged.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "romano/base/time.h"
#include "romano/mqttsn/types.h"

namespace romano::sim {

/// An application message as its publisher knows it.
struct Sent {
    std::string publisher;
    std::uint32_t number = 0;  // counts the publisher's messages
    std::string topic;
    mqttsn::Qos qos{};
    bool retain = false;
    Instant at;                           // the application asked for it
    std::optional<Instant> acknowledged;  // PUBACK, PUBCOMP
    bool refused = false;                 // ended by a return code
};

/// One that an application got.
struct Reception {
    std::string subscriber;
    std::string publisher;
    std::uint32_t number = 0;
    mqttsn::Qos qos{};  // as delivered
    bool retain = false;
    bool dup = false;
    Instant at;
};

/// While it lasts, the subscriber has a right to every message that matches.
struct SubscriptionSpan {
    std::string subscriber;
    std::string filter;
    mqttsn::Qos granted{};
    Instant from;                  // SUBACK was there
    std::optional<Instant> until;  // unsubscribed, the session given up, or switched off
};

/// A will as somebody received it.
struct WillSeen {
    std::string subscriber;
    std::string of;
    Instant at;
    mqttsn::Qos qos{};  // as delivered
    bool retain = false;
};

struct Ledger {
    std::map<std::pair<std::string, std::uint32_t>, Sent> sent;
    std::vector<Reception> receptions;
    std::vector<SubscriptionSpan> subscriptions;
    std::vector<WillSeen> wills;
    /// Where the wills go of robots whose broker has taken one.
    std::map<std::string, std::string> will_topics;
    /// When a robot fell silent for good.
    std::map<std::string, Instant> silenced;
};

/// The payload of a test message, and back. Padded to the paper's 32 octets.
[[nodiscard]] std::string to_payload(const std::string& publisher, std::uint32_t number);
[[nodiscard]] std::optional<std::pair<std::string, std::uint32_t>> from_payload(
    const std::string& payload);
[[nodiscard]] std::string will_payload(const std::string& robot);
[[nodiscard]] std::optional<std::string> from_will_payload(const std::string& payload);

}  // namespace romano::sim
