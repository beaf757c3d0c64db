// A robot's ROMANO node: the establishment phase, subscriptions on command,
// publish requests, heartbeats, and movement commands into the mailbox. Paper,
// sections "Requirements" and "The ROMANO Protocol".
//
// It drives an MQTT-SN client core and adds no storage for datagrams: what is
// to be sent goes to the owner's Port at once. No socket, no clock, no heap. It
// does not choose a broker (client/discovery.h).
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/client/client.h"
#include "romano/message/codec.h"
#include "romano/message/messages.h"
#include "romano/message/romano_id.h"
#include "romano/node/mailbox.h"

namespace romano::node {

inline constexpr std::string_view init_topic = "init-info";
inline constexpr std::string_view common_topic = "common";

/// A message comes at the QoS that its publisher chose: a movement at QoS 2 is carried out once.
inline constexpr auto subscription_qos = mqttsn::Qos::exactly_once;

struct NodeOptions {
    message::RomanoId id;
    Duration ack_timeout{
        std::chrono::seconds{2}};  // paper: 2 s, then the request is repeated, for ever
    Duration connect_again{std::chrono::seconds{1}};  // pause after a lost or refused connection
    Duration heartbeat_every{0};                      // 0: no heartbeats
    client::KeepAlive keep_alive{30};
    bool listens_to_cell = false;  // what the broker sends to many at once (mqttsn/cell.h)
    bool keep_session = false;     // the broker keeps messages while the node is away
};

/// What the node's owner lends it for the time of a call.
class Port {
public:
    /// To the broker. The octets are valid during the call only.
    virtual void send(Bytes datagram) = 0;

    /// The robot is known to a ROMANO server and hears its topics. Told again
    /// after each new connection.
    virtual void on_established() {}
    /// "Publish that kind of data to that topic": answer with Node::publish(),
    /// now or later.
    virtual void on_publish_request(std::string_view topic, Bytes kind_of_data) {
        (void)topic;
        (void)kind_of_data;
    }
    /// Every message that the node does not answer by itself: data, sensors,
    /// heartbeats, lists of nodes, the application's own types; message::decode()
    /// reads it and finds no flaw. Movements go to the mailbox instead. The topic
    /// is empty when it came under a predefined id.
    virtual void on_message(std::string_view topic, Bytes message) {
        (void)topic;
        (void)message;
    }

protected:
    ~Port() = default;
};

enum class Phase : std::uint8_t {
    stopped,
    connecting,   // CONNECT, until CONNACK
    subscribing,  // to the own id
    requesting,   // connection request on init-info, until the acknowledgement
    joining,      // subscribing to `common`
    established,
};

struct NodeCounters {
    std::uint32_t received = 0;           // ROMANO messages
    std::uint32_t malformed = 0;          // PUBLISHes whose data is none
    std::uint32_t retained_commands = 0;  // to move, of the past; they are not carried out
    std::uint32_t connections_lost = 0;
    std::uint32_t requests_sent = 0;  // connection requests
};

class Node {
public:
    /// `client`, `scratch` and `mailbox` belong to the owner and outlive the
    /// node. `scratch` is overwritten by every call.
    Node(client::ClientCore& client, client::Output& scratch, romano_mailbox& mailbox,
         const NodeOptions& options);

    void start(Instant now, Port& port);
    void on_datagram(Instant now, Bytes datagram, Port& port);
    void on_tick(Instant now, Port& port);
    [[nodiscard]] Instant next_wakeup() const;

    /// Says goodbye: the broker need not miss the node first. What is on its way may
    /// still come until then; start() begins anew.
    void leave(Instant now, Port& port);
    /// The broker confirmed the goodbye, or does not answer.
    [[nodiscard]] bool has_left() const {
        return phase_ == Phase::stopped && client_.state() == client::State::disconnected;
    }

    /// The owner talks to another broker of the same cluster from now on.
    void on_broker_changed(Instant now) { client_.on_broker_changed(now); }

    /// The owner wants to hear of the broker: a PINGREQ goes out at the next tick.
    void probe(Instant now) { client_.probe(now); }

    /// False when the client's queue is full, the message is too long, or there
    /// is no connection for a QoS 0 one. `message` is a message::Message, or one
    /// of its types when that is known: a device then links that type's encoder
    /// alone.
    template <typename M>
    bool publish(Instant now, std::string_view topic, const M& message, mqttsn::Qos qos,
                 Port& port) {
        std::array<std::uint8_t, message::max_message> room;
        return publish_octets(now, topic, Bytes{room}.first(message::encode(message, room)), qos,
                              port);
    }
    bool subscribe(Instant now, std::string_view topic, Port& port);
    /// Asks the ROMANO server for the connected nodes; they arrive as
    /// ConnectedNodes on the own id.
    bool request_connected_nodes(Instant now, Port& port);

    [[nodiscard]] Phase phase() const { return phase_; }
    [[nodiscard]] const NodeCounters& counters() const { return counters_; }

private:
    void connect(Instant now, Port& port);
    void flush(Instant now, Port& port);
    [[nodiscard]] bool is_end(const client::Event& event) const;
    void begin_again(Instant now);
    [[nodiscard]] bool is_progress(const client::Event& event) const;
    void on_progress(Instant now, const client::Event& event, Port& port);
    void enter(Phase phase, Instant now, Port& port);
    void on_received(Instant now, const client::Received& received, Port& port);
    void send_connection_request(Instant now, Port& port);
    bool publish_octets(Instant now, std::string_view topic, Bytes message, mqttsn::Qos qos,
                        Port& port);
    /// The node's own messages, without the stack that the longest one takes.
    template <typename M>
    bool publish_id(Instant now, std::string_view topic, mqttsn::Qos qos, Port& port) {
        std::array<std::uint8_t, 2 + message::RomanoId::size> room;
        const std::size_t size = message::encode(M{options_.id}, room);
        return publish_octets(now, topic, Bytes{room}.first(size), qos, port);
    }

    client::ClientCore& client_;
    client::Output& scratch_;
    romano_mailbox& mailbox_;
    NodeOptions options_;
    Phase phase_ = Phase::stopped;
    std::optional<client::OperationId> subscription_;  // of the own id, then of `common`
    Instant due_ = never;  // connecting again, or repeating the connection request
    Instant heartbeat_due_ = never;
    NodeCounters counters_;
};

}  // namespace romano::node
