// CONNECT with its will prompts, and will updates: MQTT-SN 1.2 sections 6.2 to 6.4; G7, G11, G13,
// G14, G20.
//
//     CONNECT(will) → WILLTOPICREQ   WILLTOPIC → WILLMSGREQ   WILLMSG → CONNACK
//
// Until CONNACK the old session, if there is one, goes on as it was.
#pragma once

#include <string>
#include <unordered_map>

#include "broker/core/delivery_flow.h"
#include "broker/core/enforcement.h"
#include "broker/core/lifecycle.h"
#include "broker/core/outbox.h"
#include "broker/core/stranger_answers.h"
#include "broker/core/subscriptions.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/messages.h"

namespace romano::broker {

class ConnectFlow {
public:
    ConnectFlow(Tables& tables, Outbox& outbox, DeliveryFlow& deliveries, Lifecycle& lifecycle,
                Subscriptions& subscriptions, Enforcement& enforcement)
        : tables_(tables),
          outbox_(outbox),
          deliveries_(deliveries),
          lifecycle_(lifecycle),
          subscriptions_(subscriptions),
          enforcement_(enforcement),
          answers_(tables.limits().stranger_answers_per_second) {}

    void on_connect(const Origin& origin, const mqttsn::Connect& message, Turn& turn);
    void on_willtopic(const Origin& origin, const mqttsn::Willtopic& message, Turn& turn);
    void on_willmsg(const Origin& origin, const mqttsn::Willmsg& message, Turn& turn);

    void on_willtopicupd(Session& session, const mqttsn::Willtopicupd& message, Turn& turn);
    void on_willmsgupd(Session& session, const mqttsn::Willmsgupd& message, Turn& turn);

    /// A client that is asked for its will answers there.
    [[nodiscard]] bool is_asking(const Origin& origin) const { return prompts_.contains(origin); }

    /// Forgets prompts that were never answered.
    void on_tick(Instant now);
    [[nodiscard]] Instant next_wakeup() const { return sweep_at_; }

    /// The client id of a CONNECT: an empty one is named by where it came from (G20).
    [[nodiscard]] static std::string client_id_of(const Origin& origin,
                                                  const mqttsn::Connect& message);

private:
    /// A CONNECT with the will flag, on its way to CONNACK.
    struct Prompt {
        std::string client_id;
        bool clean = true;
        std::uint16_t keep_alive_s = 0;
        mqttsn::ReturnCode refusal = mqttsn::ReturnCode::accepted;  // told after WILLMSG (G13)
        bool has_topic = false;
        Will will;
        Instant since{};
    };
    enum class WillAnswer { none, keeps_none, given };

    [[nodiscard]] mqttsn::ReturnCode judge(const Origin& origin,
                                           const mqttsn::Connect& message) const;
    [[nodiscard]] bool is_repetition(const Origin& origin, const mqttsn::Connect& message,
                                     std::string_view client_id) const;
    /// CONNACK with that.
    void refuse(const Origin& origin, mqttsn::ReturnCode why, Turn& turn);
    /// Whether to say what brings a client no further, and is not said to many at once. Clients
    /// with keys do not wait behind strangers.
    [[nodiscard]] bool may_answer(const Origin& origin, Turn& turn);
    void finish(const Origin& origin, const Prompt& prompt, WillAnswer answer, Turn& turn);
    void accept(const Origin& origin, const Prompt& prompt, WillAnswer answer, Turn& turn);
    void set_will(Session& session, std::optional<Will> will, Turn& turn);

    Tables& tables_;
    Outbox& outbox_;
    DeliveryFlow& deliveries_;
    Lifecycle& lifecycle_;
    Subscriptions& subscriptions_;
    Enforcement& enforcement_;
    StrangerAnswers answers_;
    std::unordered_map<Origin, Prompt, OriginHash> prompts_;
    Instant sweep_at_ = never;
};

}  // namespace romano::broker
