// The subscriptions and topic ids of sessions as changes that the tables, the session and the log
// see together (MQTT-SN 1.2 sections 6.5, 6.9, 6.10).
#pragma once

#include <string_view>

#include "broker/core/session.h"
#include "broker/core/tables.h"

namespace romano::broker {

class Subscriptions {
public:
    explicit Subscriptions(Tables& tables) : tables_(tables) {}

    /// Adds the subscription or replaces the one of the same filter (6.9f).
    void put(Session& session, const Subscription& subscription, Turn& turn);
    /// False when there was none (6.9h).
    bool remove(Session& session, std::string_view filter, Turn& turn);
    [[nodiscard]] bool has(const Session& session, std::string_view filter) const;

    /// Enters an adopted session's subscriptions into the tree; takes a session's out of it.
    void enter_all(const Session& session);
    void leave_all(const Session& session);

    /// The id of the name for this client, given now if need be; no_topic_id when there is no room.
    /// `known`: the client learns it by the answer that it is about to get.
    mqttsn::TopicId bind(Session& session, std::string_view name, bool known, Turn& turn);
    void set_known(Session& session, mqttsn::TopicId id, bool known, Turn& turn);

private:
    [[nodiscard]] Grant grant_of(const Session& session, const Subscription& subscription) const;
    void log_binding(const Session& session, mqttsn::TopicId id, const TopicRegistry::Topic& topic,
                     Turn& turn);

    Tables& tables_;
};

}  // namespace romano::broker
