// From one message to its receivers: the own subscribers, the retained store, the log, the peers
// (MQTT-SN 1.2 section 6.10; MQTT's rules for QoS, Retain and overlapping filters).
//
// In steps, because a publisher's answer goes before its own copy of the message (G12), and its
// time depends on the receivers.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "broker/core/cell.h"
#include "broker/core/delivery_flow.h"
#include "broker/core/enforcement.h"
#include "broker/core/outbox.h"
#include "broker/core/receiver.h"
#include "broker/core/tables.h"
#include "romano/base/bytes.h"

namespace romano::broker {

/// What a client, or a will, publishes. Views live as long as the datagram.
struct Publication {
    std::string_view topic;
    Bytes payload;
    mqttsn::Qos qos;  // 0 to 2
    bool retain;
    std::string_view origin = {};  // Message::origin
};

class Router {
public:
    Router(Tables& tables, Outbox& outbox, DeliveryFlow& deliveries, Enforcement& enforcement)
        : tables_(tables),
          outbox_(outbox),
          deliveries_(deliveries),
          enforcement_(enforcement),
          cell_(tables, deliveries) {}

    /// Every publication of a client, a will and the uplink comes by here first: Retain goes off
    /// what is not to be kept (BrokerOptions::never_retained).
    [[nodiscard]] Publication admitted(Publication publication);
    /// Keeps a message with Retain, or deletes by it; but not what is not to be kept, which a
    /// broker of an earlier version may have let in.
    void retain(const MessagePtr& message);

    /// Of what a client publishes here.
    void find_receivers(const Publication& publication, Turn& turn) {
        find_receivers(publication, {}, turn);
    }
    /// What waits in the longest queue of those, or of the topic's receivers at peers, that answer:
    /// a sleeper and one that does not answer hold up nobody; nor does the publisher itself.
    [[nodiscard]] std::size_t longest_queue(const Session& publisher, std::string_view topic,
                                            Instant now) const;
    /// Writes the message into the log and the retained store. `publisher` and `msg_id` only for
    /// QoS 2; `will_of` see Published.
    void accept(const Publication& publication, Session* publisher, mqttsn::MsgId msg_id,
                Turn& turn, const ClientId& will_of = {});
    /// Hands what was accepted last to its receivers.
    void deliver(const Publication& publication, Turn& turn);

    /// All of it, for what nobody waits for an answer about.
    void publish(const Publication& given, Turn& turn) {
        const Publication publication = admitted(given);
        find_receivers(publication, turn);
        accept(publication, nullptr, mqttsn::no_msg_id, turn);
        deliver(publication, turn);
    }

    /// What goes into the log: QoS 1 and 2, and retained.
    [[nodiscard]] static bool is_logged(const Publication& publication) {
        return publication.qos != mqttsn::Qos::at_most_once || publication.retain;
    }

    void on_peer_message(const MessagePtr& message, Turn& turn);

    /// A retained message of this broker's own: not logged, not forwarded.
    void set_system_topic(std::string_view topic, Bytes payload, Turn& turn);

    /// After SUBACK: each retained match at min(stored, granted) QoS with Retain 1. They take half
    /// of the session's queue at most: the rest comes when there is room again.
    void send_retained(Session& session, const Subscription& subscription, Turn& turn);
    void send_more_retained(Session& session, Turn& turn);

private:
    /// `position`: skip sessions that were ahead of us in that log when they came here. What has an
    /// origin is not for the session that the owner reads: it came in that way.
    void find_receivers(const Publication& publication, const LogPosition& position, Turn& turn);
    /// Those whom one datagram can serve together are done then.
    void serve_cell(const Publication& publication, std::vector<Receiver>& receivers, Turn& turn);
    /// For the owner, who reads no queue for these.
    void tell_owner(const Publication& publication, Turn& turn);
    bool send_retained_behind(Session& session, RetainedToCome& rest, Turn& turn);
    bool was_awaited(Session& session, const LogPosition& position, Turn& turn);
    void claim_room();
    [[nodiscard]] std::vector<Route> routes() const;
    MessagePtr make_message(const Publication& publication, bool in_log, Turn& turn);
    void send_at_once(const Receiver& receiver, const WireTopic& topic,
                      const Publication& publication, Turn& turn);

    Tables& tables_;
    Outbox& outbox_;
    DeliveryFlow& deliveries_;
    Enforcement& enforcement_;
    Cell cell_;
    std::vector<Receiver> receivers_;  // of the message that was accepted last
    MessagePtr message_;               // made only when something must hold it
    std::uint64_t fan_out_ = 0;
    std::uint64_t repeatable_ = 0;  // what the last PUBLISH of this fan-out looked like,
    Outbox::Octets repeated_{};     // and where its octets are
};

}  // namespace romano::broker
