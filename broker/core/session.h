// A session at its home: what its image holds, and what only the home needs: the open exchange,
// the clocks, and how far the client's datagrams must wait for the log.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "broker/core/delivery_queue.h"
#include "broker/core/session_image.h"
#include "broker/core/topic_registry.h"
#include "romano/base/time.h"

namespace romano::broker {

/// A small number that names a session within this broker while it lives here.
using SessionNumber = std::uint32_t;

/// How a topic stands in a PUBLISH to a client: an id of its type, or a short name's two octets.
struct WireTopic {
    mqttsn::TopicIdType type = mqttsn::TopicIdType::normal;
    mqttsn::TopicId id = mqttsn::no_topic_id;  // none: by the client's registry
};

/// The one exchange that is open with a client (G24). It is about the queue's current message.
struct Exchange {
    enum class Kind : std::uint8_t { none, registering, publishing, releasing };

    Kind kind = Kind::none;
    bool stalled = false;  // all retries unanswered by a silent client: waits until it is heard
    bool doubted = false;  // all retries went unanswered once: each sending brings a PINGREQ along
    bool heard = false;    // the client was heard since the first sending
    bool heard_since = false;  // and since the last one
    std::uint8_t asked = 0;    // so often for a sign of life, instead of being sent it again
    std::uint8_t ignored = 0;  // sendings after which the client was heard, but no answer
    bool refused = false;      // the message fell back once already (G21, G25)
    bool bare = false;         // without DUP and Retain (G25)
    std::uint8_t sendings = 0;
    mqttsn::MsgId msg_id = mqttsn::no_msg_id;
    WireTopic topic;  // of REGISTER and PUBLISH
    /// It went to the cell (cell.h), and to nobody alone: so long an answer may take. 0: not so.
    Duration cell_patience{0};
    Instant sent_at{};  // the first time, by this home
    Instant retry_at = never;

    [[nodiscard]] bool is_open() const { return kind != Kind::none; }
};

/// The retained messages that a new subscription asked for and that its queue had no room for yet.
struct RetainedToCome {
    Subscription subscription;
    std::string after;  // the topic that was the last one
};

/// The client answered REGISTER with "congestion": messages under that id wait (G16).
struct Pause {
    mqttsn::TopicId topic{};
    Instant until{};
};

/// PUBACK or PUBREC to a publisher that is ahead of its receivers: it comes a little later.
struct LateAnswer {
    Instant at = never;  // never: none is owed
    mqttsn::Qos qos = mqttsn::Qos::at_least_once;
    mqttsn::TopicId topic{};
    mqttsn::MsgId msg_id = mqttsn::no_msg_id;
};

/// A message behind the current one that may have been sent under that id: it goes out under it
/// again. Of QoS 2, by a former home: the client knows whether it has it. Of QoS 1, to the cell.
struct Begun {
    LogPosition position;
    mqttsn::MsgId msg_id = mqttsn::no_msg_id;
};

/// What every datagram touches stands first and close together: among thousands of sessions each
/// line of memory costs more than the work on it.
struct alignas(64) Session {
    explicit Session(SessionNumber own_number) : number(own_number) {}

    SessionHeader header;  // client_id never changes: tables refer to it

    const SessionNumber number;
    bool reachable = false;         // who was heard last where its client is: datagrams lead here
    bool fresh = false;             // nothing came since its CONNACK
    bool fresh_will = false;        // and that CONNACK ended the will prompts
    bool ignores_register = false;  // G14
    bool held = false;              // by the owner: nothing new is sent, it waits
    bool owes_pingresp = false;     // adopted awake, connected perhaps (Liveness)
    bool read_by_owner = false;     // nothing is ever sent: the owner takes from the queue
    std::uint16_t last_msg_id = 0;  // of the broker's requests to this client

    std::uint32_t matched_at = 0;  // where it stands in the fan-out that visited it last,
    std::uint64_t matched_in = 0;  // and which one that was
    Instant heard_at{};            // restarts keep-alive and the sleep timer
    Instant probe_at = never;      // the next PINGREQ of ours (G6)
    Seq output_floor = 0;          // no datagram to the client leaves before this is safe
    Exchange exchange;
    /// From an adopted image that was ahead of this broker: its part of these logs is done.
    std::vector<LogPosition> worked_ahead;
    /// But these of them were in its queue, and have not come here yet: not done.
    std::vector<Delivery> awaited;
    std::vector<Begun> begun;
    DeliveryQueue queue;
    TopicRegistry topics;

    std::vector<Subscription> subscriptions;
    std::vector<mqttsn::MsgId> unreleased;
    std::vector<RetainedToCome> retained_to_come;  // one a filter; no part of the image
    std::optional<Will> will;
    Instant departed_at = never;   // when it became disconnected or lost
    Instant displaced_at = never;  // when another client got its address, while connected (G7)
    std::vector<Pause> pauses;     // one a topic
    LateAnswer late_answer;
    /// Of the QoS 2 exchange that another home of this session left open.
    mqttsn::MsgId unfinished = mqttsn::no_msg_id;

    [[nodiscard]] bool is_connected() const { return broker::is_connected(header); }
    [[nodiscard]] bool is_at(const Origin& place) const {
        return header.address == place.from && header.via == place.via;
    }
    /// Something can be sent to it now.
    [[nodiscard]] bool is_listening() const {
        return reachable &&
               (header.state == SessionState::active || header.state == SessionState::awake);
    }
    /// It was sent something after `since`, and may well answer.
    [[nodiscard]] bool is_answering(Instant since) const {
        return exchange.is_open() && exchange.sent_at > since && !exchange.stalled;
    }
    /// Asleep as far as its former homes knew, but it speaks as the connected do (Liveness).
    [[nodiscard]] bool seems_connected() const {
        return header.state == SessionState::active && header.sleep_s != 0;
    }
    /// A publish of QoS 1 or 2 is kept for it.
    [[nodiscard]] bool keeps_messages() const { return broker::keeps_messages(header); }
};

}  // namespace romano::broker
