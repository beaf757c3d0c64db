// Messages on their way to a client: one exchange at a time, the rest in the session's queue
// (MQTT-SN 1.2 sections 6.10, 6.13; G5, G14, G16, G21, G24, G25).
//
//     queued ──(id unknown)── REGISTER → REGACK ──┐
//        └──────────────────────────────────────── PUBLISH → PUBACK                     QoS 1
//                                                  PUBLISH → PUBREC → PUBREL → PUBCOMP  QoS 2
//
// QoS 0 goes out at once when the client is active, knows the id, and nothing of QoS 0 waits.
//
// A client that answers, but never for one message, cannot take it: too long for its buffer. After
// all retries the broker asks with PINGREQ whether it is there. While it is, the message is sent
// again, each time with PINGREQ behind it; when it was passed over often enough, it is dropped. To
// one that is out of reach nothing is dropped.
#pragma once

#include <cstddef>
#include <string_view>

#include "broker/core/enforcement.h"
#include "broker/core/outbox.h"
#include "broker/core/session.h"
#include "broker/core/subscriptions.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/messages.h"

namespace romano::broker {

class DeliveryFlow {
public:
    DeliveryFlow(Tables& tables, Outbox& outbox, Subscriptions& subscriptions,
                 Enforcement& enforcement)
        : tables_(tables),
          outbox_(outbox),
          subscriptions_(subscriptions),
          enforcement_(enforcement) {}

    /// True when a message of this QoS can join the queue; drops the oldest of QoS 0 for it.
    bool make_room(Session& session);

    /// Joins the queue, in which there is room, and goes out if it is its turn.
    void enqueue(Session& session, Delivery delivery, Turn& turn);

    /// The id by which a QoS 0 message may go out now, or none: then it waits or is not for now.
    [[nodiscard]] bool can_send_at_once(Session& session, WireTopic& topic, std::string_view name);

    /// It may go to the cell in this very turn, as what it is and under an id that the client
    /// knows: nothing is before it, or nothing but what went to the cell as well, and not too much
    /// of it.
    [[nodiscard]] bool can_take_now(Session& session, WireTopic& topic, std::string_view name,
                                    mqttsn::Qos qos);
    /// A message of QoS 1 that can_take_now() went to the cell, under the msg id behind the
    /// session's last one, which is returned. Without an answer for so long it follows by unicast.
    mqttsn::MsgId follow_cell(Session& session, const MessagePtr& message, const WireTopic& topic,
                              Duration patience, Turn& turn);

    /// The owner is done with this message of the session that it reads.
    void on_read(Session& session, const LogPosition& position, Turn& turn);

    void on_regack(Session& session, const mqttsn::Regack& message, Turn& turn);
    void on_puback(Session& session, const mqttsn::Puback& message, Turn& turn);
    void on_pubrec(Session& session, const mqttsn::Pubrec& message, Turn& turn);
    void on_pubcomp(Session& session, const mqttsn::Pubcomp& message, Turn& turn);

    /// Of an exchange that another home left open, if there is one (Session::unfinished). A QoS 2
    /// receiver takes a later message with that id for the one that it holds: PUBREL goes out, now
    /// and before each such message, until it is answered.
    void release_unfinished(Session& session, Turn& turn);

    /// Opens the next exchange if none is open and the client listens; ends being awake when
    /// nothing is left (6.14b).
    void go_on(Session& session, Turn& turn);

    /// The client was heard, and its message handled: what its silence had stopped goes on (G5).
    void resume(Session& session, Turn& turn);

    /// Forgets the pauses that are over, and goes on.
    void end_pauses(Session& session, Turn& turn);

    /// Retransmission is due.
    void on_retry(Session& session, Turn& turn);
    /// A PUBLISH is due again to a client that may be heard elsewhere: the exchange may be over
    /// there, and at QoS 2 it would take what comes once more for another message (P3). It is asked
    /// for a sign of life instead, and the PUBLISH goes out again when one comes.
    void ask(Session& session, Turn& turn);

    /// Sends the open message again, because the client asks for it (G10). False: none is open.
    bool repeat(Session& session, Turn& turn);

    /// Sends the open message again, unless it went out in this very turn; opens the next exchange
    /// when none is open.
    void send_again(Session& session, Turn& turn);

private:
    enum class Readiness { ready, must_register, impossible };
    /// Completes `topic` for this client; why it cannot be used is counted.
    Readiness prepare(Session& session, WireTopic& topic, std::string_view name, Turn& turn);
    [[nodiscard]] WireTopic plain_topic(const Session& session, std::string_view name);

    /// Makes the first message whose topic does not wait (G16) the current one; one that was begun
    /// stays it, for its client may hold it. False when there is none.
    bool choose(Session& session, Instant now);
    [[nodiscard]] bool is_paused(const Session& session, const Delivery& delivery, Instant now);

    [[nodiscard]] bool is_silent(const Session& session, Instant now) const;
    /// False when the current message was dropped or went out without an exchange.
    bool open_front(Session& session, Turn& turn);
    bool publish_front(Session& session, const WireTopic& topic, Turn& turn);
    void publish_anyway(Session& session, bool known, Turn& turn);
    void start(Session& session, Delivery& delivery, Turn& turn);
    bool send_open(Session& session, bool again, Turn& turn);
    bool send_publish(Session& session, const Delivery& delivery, const WireTopic& topic, bool dup,
                      Turn& turn);
    static void open(Session& session, Exchange::Kind kind, mqttsn::MsgId msg_id,
                     const WireTopic& topic);
    void fall_back(Session& session, mqttsn::Qos most, bool bare, Turn& turn);
    void await_cell(Session& session, const WireTopic& topic, Duration patience, Turn& turn);
    [[nodiscard]] static std::size_t behind_front_at_cell(const Session& session,
                                                          mqttsn::MsgId msg_id);
    void end_at_cell(Session& session, std::size_t behind, Turn& turn);
    void end_front(Session& session, Turn& turn);
    void drop_front(Session& session, Drop reason, Turn& turn);
    void supervise(Session& session, Turn& turn);
    [[nodiscard]] Duration patience_with(Session& session);
    [[nodiscard]] bool names_known_id(Session& session);
    void give_up(Session& session, Turn& turn);
    [[nodiscard]] bool is_passed_over(const Session& session) const;
    void doubt(Session& session, Turn& turn);
    [[nodiscard]] static bool is_left_at(Session& session, DeliveryStage stage,
                                         mqttsn::MsgId msg_id);
    void release_front(Session& session, Turn& turn);
    void fall_asleep(Session& session, Turn& turn);
    [[nodiscard]] static mqttsn::MsgId msg_id_for(Session& session, const Delivery& delivery);
    [[nodiscard]] static mqttsn::MsgId next_msg_id(Session& session);

    Tables& tables_;
    Outbox& outbox_;
    Subscriptions& subscriptions_;
    Enforcement& enforcement_;
};

}  // namespace romano::broker
