// What must survive of a session: plain data that its home can hand to another broker.
//
// The home works on its own `Session`; a mirror keeps SessionImages and applies log events to them.
// Taking a session over means: image in, and go on where it stopped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "broker/core/client_address.h"
#include "broker/core/hybrid_time.h"
#include "broker/core/message.h"
#include "romano/mqttsn/types.h"

namespace romano::broker {

using ClientId = std::string;

/// MQTT-SN 1.2 section 6.14, figure 4.
enum class SessionState : std::uint8_t { active, asleep, awake, disconnected, lost };
inline constexpr std::size_t session_states = 5;

struct Subscription {
    std::string filter;  // a name, a filter with wildcards, or a short name
    /// How the client subscribed, and so how a plain match is delivered.
    mqttsn::TopicIdType type = mqttsn::TopicIdType::normal;
    mqttsn::TopicId predefined_id = mqttsn::no_topic_id;  // for type predefined
    mqttsn::Qos granted = mqttsn::Qos::at_most_once;

    friend bool operator==(const Subscription&, const Subscription&) = default;
};

struct TopicBinding {
    mqttsn::TopicId id{};
    std::string name;
    bool known_to_client = false;  // from REGACK, SUBACK or an accepted REGISTER

    friend bool operator==(const TopicBinding&, const TopicBinding&) = default;
};

struct Will {
    std::string topic;
    std::vector<std::uint8_t> message;
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;
    bool retain = false;

    friend bool operator==(const Will&, const Will&) = default;
};

enum class DeliveryStage : std::uint8_t {
    queued,     // not sent yet
    published,  // PUBLISH sent with msg_id; waiting for PUBACK or PUBREC
    released,   // PUBREC received, PUBREL sent; waiting for PUBCOMP
};

/// A QoS 1 or 2 message on its way to the client. `message` is null in a mirror that has not seen
/// the Published event yet; `position` always names it.
struct Delivery {
    LogPosition position;
    MessagePtr message;
    mqttsn::Qos qos = mqttsn::Qos::at_least_once;  // min(published, granted)
    bool retain = false;                           // sent because of a new subscription
    DeliveryStage stage = DeliveryStage::queued;
    mqttsn::MsgId msg_id = mqttsn::no_msg_id;
};

/// What changes often, apart from the lists.
struct SessionHeader {
    ClientId client_id;
    ClientAddress address;
    Endpoint via;  // the service address that the client talks to
    SessionState state = SessionState::active;
    bool clean = true;
    std::uint16_t keep_alive_s = 0;
    std::uint16_t sleep_s = 0;
    /// Counts the homes at which the client was heard. A session that was begun anew, or that the
    /// client has connected to again, counts from the time of that, so that it outranks older ones
    /// of which its broker knew nothing, and those that do not know of it.
    std::uint64_t epoch = 1;
    bool provisional = false;  // adopted, and the client was not heard at this home yet
    HybridTime last_heard;     // a mirror's is as of the last event, not of the last datagram
    HybridTime departed;       // when it became disconnected or lost; 0: it is connected
    /// When its last PUBLISH or PUBREL of QoS 2 was heard: of two copies the one where that is
    /// later knows what it publishes. A mirror's is as of the last PUBLISH.
    HybridTime last_published;
    friend bool operator==(const SessionHeader&, const SessionHeader&) = default;
};

/// Answers a question about one client.
using SessionJudgement = std::function<bool(const SessionHeader& client)>;

[[nodiscard]] inline bool is_connected(const SessionHeader& header) {
    return header.state == SessionState::active || header.state == SessionState::asleep ||
           header.state == SessionState::awake;
}
/// A publish of QoS 1 or 2 is kept for it. Also for a lost client's clean session: the client may
/// be out of this broker's sight alone, and awake or asleep for all that it knows.
[[nodiscard]] inline bool keeps_messages(const SessionHeader& header) {
    return header.state != SessionState::disconnected || !header.clean;
}

struct SessionImage {
    SessionHeader header;
    std::optional<Will> will;
    std::vector<Subscription> subscriptions;
    std::vector<TopicBinding> topics;
    std::vector<Delivery> deliveries;       // in order; one of the first is in flight, if any
    std::vector<mqttsn::MsgId> unreleased;  // QoS 2 msgIds received, PUBREL not yet seen
    /// How far the home had worked through each log, its own included, sorted by log: what was
    /// published up to there is in `deliveries`, done, or was not for this session.
    std::vector<LogPosition> worked_through;
    mqttsn::MsgId last_msg_id = mqttsn::no_msg_id;  // that the home gave; a mirror knows PUBLISH's
};

/// How far the home had worked through that log.
[[nodiscard]] Seq worked_through(const SessionImage& image, const LogId& log);

/// True when both describe the same session in the same state, apart from when it was heard and
/// published last and departed, and the last msg id; messages are compared by their positions.
[[nodiscard]] bool same_state(const SessionImage& a, const SessionImage& b);

/// Which of two copies of one session counts when brokers meet: the higher epoch, then one whose
/// client was heard at its home, then the one that was heard later.
[[nodiscard]] inline bool outranks(const SessionHeader& a, const SessionHeader& b) {
    if (a.epoch != b.epoch) return a.epoch > b.epoch;
    if (a.provisional != b.provisional) return b.provisional;
    return a.last_heard > b.last_heard;
}

}  // namespace romano::broker
