// The events of a broker's log: all that must survive the broker, in the order in which it
// happened.
//
// The writer is the home of the sessions it writes about. A mirror that applies every event in
// order holds the same images as the home. QoS 0 and -1 traffic is not logged.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "broker/core/session_image.h"
#include "romano/base/shared.h"

namespace romano::broker {

/// The session as it now stands, replacing all that was known: a clean connect, or an adoption.
struct SessionPut {
    SessionImage image;
    /// Of an adoption: the SessionMoved that it answers, in the log of the session's former home.
    std::optional<LogPosition> adopted = {};
};
/// Address, state, keep-alive or epoch changed; the lists did not, except as `forgets_topics` says.
struct SessionChanged {
    SessionHeader header;
    /// A kept session was connected anew: no topic id counts as known to the client any more (G14).
    bool forgets_topics = false;
};
/// The session is gone for good.
struct SessionErased {
    ClientId client_id;
};
/// The session goes to the broker with that log, which adopts it from its mirror of this one: as it
/// stands here, and with this header. Nothing follows of it.
struct SessionMoved {
    SessionHeader header;
    LogId to;
};
/// All sessions of that service address that were here have moved: the broker with that log speaks
/// there.
struct Sealed {
    Endpoint address;
    LogId to;
};
struct WillChanged {
    ClientId client_id;
    std::optional<Will> will;
};
/// Adds the subscription or replaces the one with the same filter.
struct Subscribed {
    ClientId client_id;
    Subscription subscription;
};
struct Unsubscribed {
    ClientId client_id;
    std::string filter;
};
/// Adds the binding or replaces the one with the same id.
struct TopicBound {
    ClientId client_id;
    TopicBinding binding;
};

/// One of the writer's sessions that a message was queued for.
struct Route {
    ClientId client_id;
    mqttsn::Qos qos;
    bool retain = false;
};
/// A publish of one of the writer's clients, or a will: QoS 1 or 2, or retained. The message's
/// position is this event's. For QoS 2 `publisher` and `msg_id` let a repetition be recognised.
struct Published {
    MessagePtr message;
    ClientId publisher;  // empty unless QoS 2 from a session
    mqttsn::MsgId msg_id = mqttsn::no_msg_id;
    std::vector<Route> routes;  // the writer's own sessions (QoS 1 and 2 only)
    /// The message is the will of this session, which is lost with this event: nobody ever holds
    /// the one and not the other.
    ClientId will_of = {};
};
/// The writer worked on a peer's message (or a retained one): queued for these of its sessions.
/// Implies a Cursor at that position when the message is of a peer's log and a live one: the routes
/// of a retained message that a new subscription asked for have `retain` set and imply nothing.
struct Routed {
    LogPosition message;
    std::vector<Route> routes;
};
/// The writer has worked through the publishes of these peers up to and including `through`: those
/// that moved since it said so last, by log. In one event, for with each broker there are more of
/// them, and more who read it.
struct Cursor {
    std::vector<LogPosition> through;
};
/// The delivery was sent with this msg id (QoS 2: before it is sent).
struct DeliveryStarted {
    ClientId client_id;
    LogPosition message;
    mqttsn::MsgId msg_id;
    mqttsn::Qos qos;  // may be lower than routed: a client that refuses QoS 2
};
/// PUBREC arrived.
struct DeliveryReleased {
    ClientId client_id;
    LogPosition message;
};
/// Acknowledged to the end, or dropped for good.
struct DeliveryEnded {
    ClientId client_id;
    LogPosition message;
};
/// PUBREL arrived for a QoS 2 publish of the client: the msg id is free again.
struct PublishReleased {
    ClientId client_id;
    mqttsn::MsgId msg_id;
};

using LogEvent =
    std::variant<SessionPut, SessionChanged, SessionErased, WillChanged, Subscribed, Unsubscribed,
                 TopicBound, Published, Routed, Cursor, DeliveryStarted, DeliveryReleased,
                 DeliveryEnded, PublishReleased, SessionMoved, Sealed>;

/// As logs and batches have it: a log is kept in many places, and its events are as large as the
/// largest kind.
using LogEventPtr = Shared<LogEvent>;

/// The session that is not at this home any more after the event; null when there is none.
[[nodiscard]] inline const ClientId* leaver(const LogEvent& event) {
    if (const auto* erased = std::get_if<SessionErased>(&event)) return &erased->client_id;
    if (const auto* moved = std::get_if<SessionMoved>(&event)) return &moved->header.client_id;
    return nullptr;
}

/// Calls `look(const ClientId&)` for each of the writer's sessions that the event changes; for some
/// more than once.
template <typename Look>
void visit_changed_sessions(const LogEvent& event, Look&& look) {
    const auto visit_routes = [&look](const std::vector<Route>& routes) {
        for (const Route& route : routes) look(route.client_id);
    };
    std::visit(
        [&](const auto& e) {
            using Event = std::decay_t<decltype(e)>;
            if constexpr (std::is_same_v<Event, SessionPut>) {
                look(e.image.header.client_id);
            } else if constexpr (std::is_same_v<Event, SessionChanged> ||
                                 std::is_same_v<Event, SessionMoved>) {
                look(e.header.client_id);
            } else if constexpr (std::is_same_v<Event, Published>) {
                if (!e.publisher.empty()) look(e.publisher);
                if (!e.will_of.empty()) look(e.will_of);
                visit_routes(e.routes);
            } else if constexpr (std::is_same_v<Event, Routed>) {
                visit_routes(e.routes);
            } else if constexpr (!std::is_same_v<Event, Cursor> && !std::is_same_v<Event, Sealed>) {
                look(e.client_id);
            }
        },
        event);
}

}  // namespace romano::broker
