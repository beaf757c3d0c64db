// Whether clients are alive, asleep or gone: PINGREQ, DISCONNECT, and the timers of every session
// (MQTT-SN 1.2 sections 6.11, 6.12, 6.14; G6, G9, G10, G11, G28).
#pragma once

#include "broker/core/delivery_flow.h"
#include "broker/core/lifecycle.h"
#include "broker/core/outbox.h"
#include "broker/core/publish_flow.h"
#include "broker/core/session.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/messages.h"

namespace romano::broker {

class Liveness {
public:
    Liveness(Tables& tables, Outbox& outbox, DeliveryFlow& deliveries, Lifecycle& lifecycle,
             PublishFlow& publishes)
        : tables_(tables),
          outbox_(outbox),
          deliveries_(deliveries),
          lifecycle_(lifecycle),
          publishes_(publishes) {}

    /// A datagram of the session's client came from there.
    void on_heard(Session& session, const Origin& origin, mqttsn::MsgType type, Turn& turn);

    void on_pingreq(Session& session, const mqttsn::Pingreq& message, Turn& turn);
    void on_disconnect(Session& session, const mqttsn::Disconnect& message, Turn& turn);

    /// All sessions that are due; `may_be_unheard` as in BrokerCore::on_tick(). Whoever looks late
    /// stood still, and nobody is lost for that: what clients said meanwhile may wait to be read.
    void on_tick(const SessionJudgement& may_be_unheard, Turn& turn);

private:
    void look_at(Session& session, bool is_unheard, bool stood_still, Turn& turn);

    Tables& tables_;
    Outbox& outbox_;
    DeliveryFlow& deliveries_;
    Lifecycle& lifecycle_;
    PublishFlow& publishes_;
};

}  // namespace romano::broker
