// PUBLISH from clients: MQTT-SN 1.2 sections 6.6 and 6.8; G19, G22, G23.
#pragma once

#include <string>
#include <string_view>

#include "broker/core/enforcement.h"
#include "broker/core/outbox.h"
#include "broker/core/router.h"
#include "broker/core/session.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/messages.h"

namespace romano::broker {

class PublishFlow {
public:
    PublishFlow(Tables& tables, Outbox& outbox, Router& router, Enforcement& enforcement)
        : tables_(tables), outbox_(outbox), router_(router), enforcement_(enforcement) {}

    void on_publish(Session& session, const mqttsn::Publish& message, Turn& turn);
    /// A late PUBACK or PUBREC is due.
    void answer_what_is_owed(Session& session, Turn& turn);
    void on_pubrel(Session& session, const mqttsn::Pubrel& message, Turn& turn);
    /// QoS -1, from anybody; never answered (6.8a).
    void on_connectionless(const Origin& origin, const mqttsn::Publish& message, Turn& turn);

private:
    [[nodiscard]] mqttsn::ReturnCode judge(const mqttsn::Publish& message, std::string_view topic);
    /// The topic's name, held in `name_`; empty when the id is unknown.
    [[nodiscard]] std::string_view name_of(Session* session, const mqttsn::Publish& message);
    [[nodiscard]] Duration delay_of(const Session& publisher, std::string_view topic,
                                    Instant now) const;
    void say(Session& session, const LateAnswer& answer, Turn& turn);
    void observe(const Session& session, const Publication& publication, Turn& turn);
    void remember_unreleased(Session& session, mqttsn::MsgId msg_id, Turn& turn);

    Tables& tables_;
    Outbox& outbox_;
    Router& router_;
    Enforcement& enforcement_;
    std::string name_;
};

}  // namespace romano::broker
