// The states of a session, MQTT-SN 1.2 section 6.14 figure 4, and its beginning and end: each
// change seen by tables, timers and log together.
//
//                 ┌─ DISCONNECT(d) ─▶ asleep ◀─ PINGREQ / PINGRESP ─▶ awake
//     CONNECT ─▶ active ─ DISCONNECT ─▶ disconnected
//                 └───── silence ─────▶ lost (the will is published)
#pragma once

#include <string_view>

#include "broker/core/enforcement.h"
#include "broker/core/router.h"
#include "broker/core/session.h"
#include "broker/core/subscriptions.h"
#include "broker/core/tables.h"

namespace romano::broker {

class Lifecycle {
public:
    Lifecycle(Tables& tables, Router& router, Subscriptions& subscriptions,
              Enforcement& enforcement)
        : tables_(tables),
          router_(router),
          subscriptions_(subscriptions),
          enforcement_(enforcement) {}

    /// A new, empty session; null when there is no room, and none can be made.
    Session* create(std::string_view client_id, Turn& turn);

    /// Forgets one whose client is away: a clean one that was left behind, or whose place another
    /// client has by now, else a kept one of the IP address that has most of those. The only kept
    /// one of an IP address stays. False when there is none to go.
    bool make_room(Turn& turn);

    /// Subscriptions, topic ids, messages and will are gone (6.3, CleanSession 1). Not logged.
    void wipe(Session& session);

    /// The session is gone for good.
    void erase(Session& session, Actions& out);
    /// It is not here any more, and the log says why.
    void forget(Session& session);

    /// The client is heard there: its datagrams lead to this session. True when that is news.
    bool move(Session& session, const Origin& place, Turn& turn);
    /// It comes from another home, and was heard there: unless another client was heard there
    /// later, or it lost its place before, its datagrams lead to this session.
    void settle_at(Session& session, const Origin& place, Turn& turn);

    void sleep(Session& session, std::uint16_t duration_s, Turn& turn);
    void wake(Session& session, Turn& turn);
    void disconnect(Session& session, Turn& turn);
    /// Silent for too long: publishes the will.
    void lose(Session& session, Turn& turn);

    void log_header(const Session& session, Turn& turn, bool forgets_topics = false);

private:
    void depart(Session& session, SessionState state, Turn& turn);
    void depart_lost(Session& session, Turn& turn);
    void forget(Session& session, Turn& turn);
    /// Of kept sessions without their clients an IP address has so many (Limits); this one is new.
    void heed_limit_of_absent(const Session& session, Turn& turn);
    void publish_will(Session& session, Turn& turn);

    Tables& tables_;
    Router& router_;
    Subscriptions& subscriptions_;
    Enforcement& enforcement_;
};

}  // namespace romano::broker
