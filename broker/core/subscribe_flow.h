// REGISTER, SUBSCRIBE and UNSUBSCRIBE from clients: MQTT-SN 1.2 sections 6.5 and 6.9; G15, G17,
// G18.
#pragma once

#include <string_view>

#include "broker/core/enforcement.h"
#include "broker/core/outbox.h"
#include "broker/core/router.h"
#include "broker/core/session.h"
#include "broker/core/subscriptions.h"
#include "broker/core/tables.h"
#include "romano/base/result.h"
#include "romano/mqttsn/messages.h"

namespace romano::broker {

class SubscribeFlow {
public:
    SubscribeFlow(Tables& tables, Outbox& outbox, Router& router, Subscriptions& subscriptions,
                  Enforcement& enforcement)
        : tables_(tables),
          outbox_(outbox),
          router_(router),
          subscriptions_(subscriptions),
          enforcement_(enforcement) {}

    void on_register(Session& session, const mqttsn::Register& message, Turn& turn);
    void on_subscribe(Session& session, const mqttsn::Subscribe& message, Turn& turn);
    void on_unsubscribe(Session& session, const mqttsn::Unsubscribe& message, Turn& turn);

private:
    /// The filter that the message names, or why there is none.
    [[nodiscard]] Result<std::string_view, mqttsn::ReturnCode> filter_of(
        const mqttsn::TopicRef& topic) const;
    [[nodiscard]] mqttsn::ReturnCode judge(const Session& session, const mqttsn::Subscribe& message,
                                           std::string_view filter) const;
    void refuse(Session& session, const mqttsn::Subscribe& message, mqttsn::ReturnCode code,
                Turn& turn);

    Tables& tables_;
    Outbox& outbox_;
    Router& router_;
    Subscriptions& subscriptions_;
    Enforcement& enforcement_;
};

}  // namespace romano::broker
