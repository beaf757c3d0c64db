// The way of a datagram: which message it is, whose session it belongs to, and which procedure
// takes it; and what is said to whom has no session (MQTT-SN 1.2 sections 5.5 and 6; G8).
#pragma once

#include "broker/core/connect_flow.h"
#include "broker/core/delivery_flow.h"
#include "broker/core/discovery.h"
#include "broker/core/enforcement.h"
#include "broker/core/lifecycle.h"
#include "broker/core/liveness.h"
#include "broker/core/outbox.h"
#include "broker/core/publish_flow.h"
#include "broker/core/router.h"
#include "broker/core/stranger_answers.h"
#include "broker/core/stranger_limit.h"
#include "broker/core/subscribe_flow.h"
#include "broker/core/subscriptions.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/codec.h"

namespace romano::broker {

class Reception {
public:
    Reception(Tables& tables, Outbox& outbox, Enforcement& enforcement,
              Subscriptions& subscriptions, DeliveryFlow& deliveries, Router& router,
              Lifecycle& lifecycle)
        : tables_(tables),
          outbox_(outbox),
          deliveries_(deliveries),
          router_(router),
          lifecycle_(lifecycle),
          publish_flow_(tables, outbox, router, enforcement),
          subscribe_flow_(tables, outbox, router, subscriptions, enforcement),
          connect_flow_(tables, outbox, deliveries, lifecycle, subscriptions, enforcement),
          liveness_(tables, outbox, deliveries, lifecycle, publish_flow_),
          discovery_(tables, outbox),
          strangers_(tables.limits().stranger_datagrams_per_second,
                     tables.limits().address_stranger_datagrams_per_second),
          disconnects_(tables.limits().stranger_answers_per_second) {}

    /// `wrapped`: it was in a forwarder's frame.
    void on_datagram(const Origin& origin, Bytes datagram, bool wrapped, Turn& turn);
    void on_tick(const SessionJudgement& may_be_unheard, Turn& turn);
    [[nodiscard]] Instant next_wakeup() const;

    /// What comes from there is not another broker's to answer.
    [[nodiscard]] bool knows(const Origin& origin) const {
        return tables_.sessions.find(origin) != nullptr || connect_flow_.is_asking(origin) ||
               session_at(origin) != nullptr;
    }

private:
    void on_encapsulated(const Origin& origin, const mqttsn::Encapsulated& frame, Turn& turn);
    void on_session_message(const Origin& origin, const mqttsn::Message& message, Turn& turn);
    /// Of the connected client that speaks there, or null. One that was heard at another service
    /// address has come here if nobody else is connected from its address.
    [[nodiscard]] Session* session_at(const Origin& origin) const;
    /// The session that a datagram belongs to, or null.
    Session* session_of(const Origin& origin, const mqttsn::Message& message) const;
    void handle(Session& session, const mqttsn::Message& message, Turn& turn);
    void on_stranger(const Origin& origin, mqttsn::MsgType type, Turn& turn);
    /// Who is connected is; others up to a rate.
    [[nodiscard]] bool is_heeded(const Origin& origin, Turn& turn);

    Tables& tables_;
    Outbox& outbox_;
    DeliveryFlow& deliveries_;
    Router& router_;
    Lifecycle& lifecycle_;
    PublishFlow publish_flow_;
    SubscribeFlow subscribe_flow_;
    ConnectFlow connect_flow_;
    Liveness liveness_;
    Discovery discovery_;
    StrangerLimit strangers_;
    StrangerAnswers disconnects_;
};

}  // namespace romano::broker
