// An MQTT-SN 1.2 client without a socket, a clock, a heap or exceptions.
//
//   client::Client<> robot{{.t_retry = 2s}, seed};
//   client::OutputFor<> out;
//   robot.connect(now, {.client_id = "robot-7"}, out);
//   robot.subscribe(now, topic_name("commands/#"), Qos::exactly_once, out);
//   robot.publish(now, topic_name("pose"), as_octets("x=1"), {.qos = Qos::at_least_once}, out);
//
// After each call the owner sends out.datagrams() to the broker and handles out.events()
// (events.h); it calls on_datagram() with what comes from the broker's address, and on_tick() at
// next_wakeup().
//
// It connects with or without a will, registers names by itself before it publishes on them,
// publishes and receives at every QoS (QoS 2 exactly once), repeats what is not answered (Tretry,
// Nretry), registers anew after PUBACK 2, pauses for T_WAIT after "congestion", keeps the session
// alive, answers the broker's pings and sleeps. Operations may be asked for at any time, also
// before CONNACK: they wait in a bounded queue and go out one after the other, as the specification
// wants. It does not choose a gateway (discovery.h) nor connect again by itself after Lost.
//
// The exchanges have a file each: connection.cpp (6.2, 6.12), registering.cpp (6.5),
// publishing.cpp (6.6, 6.8), subscribing.cpp (6.9), receiving.cpp (6.10), keep_alive.cpp (6.11),
// sleeping.cpp (6.14), will_update.cpp (6.4); cell.cpp has what the broker sends to many at once.
// The answers to what the application asked for are so much alike that answers.cpp handles them
// all.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "romano/base/bytes.h"
#include "romano/base/random.h"
#include "romano/base/result.h"
#include "romano/base/time.h"
#include "romano/client/events.h"
#include "romano/client/limits.h"
#include "romano/client/operations.h"
#include "romano/client/retry_timer.h"
#include "romano/client/topic_table.h"
#include "romano/mqttsn/body.h"
#include "romano/mqttsn/messages.h"
#include "romano/mqttsn/types.h"

namespace romano::client {

/// Section 7.2.
struct Timing {
    Duration t_retry{mqttsn::default_t_retry};
    Duration t_wait{mqttsn::default_t_wait};
    int n_retry = mqttsn::default_n_retry;
};

/// The views must stay valid until another connect().
struct Will {
    std::string_view topic;
    Bytes message;
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;
    bool retain = false;
};
/// Seconds as on the wire; 0: no supervision.
using KeepAlive = std::chrono::duration<std::uint16_t>;

struct ConnectOptions {
    std::string_view client_id;
    bool clean_session = true;
    KeepAlive keep_alive{60};
    std::optional<Will> will = std::nullopt;
};

struct PublishOptions {
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;
    bool retain = false;
};

/// The ways to name a topic. The octets of a short name are one or two.
constexpr mqttsn::TopicRef topic_name(std::string_view name) {
    return {mqttsn::TopicIdType::normal, name, mqttsn::no_topic_id};
}
constexpr mqttsn::TopicRef short_topic(std::string_view name) {
    return {mqttsn::TopicIdType::short_name, name, mqttsn::no_topic_id};
}
constexpr mqttsn::TopicRef predefined_topic(mqttsn::TopicId id) {
    return {mqttsn::TopicIdType::predefined, {}, id};
}

/// Why an operation was not begun.
enum class Refusal : std::uint8_t {
    queue_full,     // too much waits for the broker already
    too_long,       // no datagram of this client holds it
    invalid_topic,  // empty, a short name over two octets, or a plain name at QoS -1
    not_connected,  // QoS 0 is not kept for a later connection
};

enum class State : std::uint8_t {
    disconnected,  // never connected, refused, said so, or lost
    connecting,
    connected,
    disconnecting,
    falling_asleep,
    asleep,
    awake,  // asleep, and collecting its messages
};

class ClientCore {
public:
    ClientCore(const ClientCore&) = delete;
    ClientCore& operator=(const ClientCore&) = delete;

    /// Begins a connection; from any state. With a clean session the known topic ids are forgotten.
    /// Ends in Connected, Refused or Lost.
    void connect(Instant now, const ConnectOptions& options, Output& out);

    /// Ends in Disconnected, also when nobody answers. Waiting operations are kept.
    void disconnect(Instant now, Output& out);

    /// Tells the broker to keep messages; ends in Asleep. From then on the client collects them by
    /// itself within each `duration`. connect() without clean session ends the sleep.
    void sleep(Instant now, std::chrono::seconds duration, Output& out);

    /// Collects now what the broker keeps for the sleeper; ends in Asleep.
    void wake(Instant now, Output& out);

    /// QoS -1 needs a short or predefined topic, and no connection. QoS 0 leaves at once when the
    /// topic's id is known. Ends in Published or Failed.
    Result<OperationId, Refusal> publish(Instant now, const mqttsn::TopicRef& topic, Bytes data,
                                         const PublishOptions& options, Output& out);

    /// Ends in Subscribed or Failed.
    Result<OperationId, Refusal> subscribe(Instant now, const mqttsn::TopicRef& topic,
                                           mqttsn::Qos qos, Output& out);

    /// Ends in Unsubscribed.
    Result<OperationId, Refusal> unsubscribe(Instant now, const mqttsn::TopicRef& topic,
                                             Output& out);

    /// publish() does this by itself; of use to know a topic's id early. Ends in Registered or
    /// Failed.
    Result<OperationId, Refusal> register_name(Instant now, std::string_view name, Output& out);

    /// Replaces the will's topic, QoS and Retain; an empty topic deletes the will. Ends in
    /// WillUpdated or Failed, as does the next.
    Result<OperationId, Refusal> update_will_topic(Instant now, std::string_view topic,
                                                   const PublishOptions& options, Output& out);
    Result<OperationId, Refusal> update_will_message(Instant now, Bytes message, Output& out);

    /// Whatever came from the broker's address, be it to the multicast group of its cell: what is
    /// sent there counts once subscribe(topic_name(mqttsn::cell_topic)) ended in Subscribed. A
    /// listener says so anew after each connect(). What is no message, or none that a client
    /// receives in this state, is dropped and counted.
    void on_datagram(Instant now, Bytes datagram, Output& out);

    /// Early or repeated ticks are harmless.
    void on_tick(Instant now, Output& out);

    /// `never` when nothing is due; may be in the past.
    [[nodiscard]] Instant next_wakeup() const;

    /// The owner talks to another broker of the same cluster from now on: a PINGREQ is due, so that
    /// the session comes there, and the open request once more.
    void on_broker_changed(Instant now);

    /// A PINGREQ is due, unless one is out: the owner wants to hear of the broker.
    void probe(Instant now);

    [[nodiscard]] State state() const { return state_; }
    [[nodiscard]] bool is_connected() const { return state_ == State::connected; }
    /// True when no operation waits for the broker.
    [[nodiscard]] bool is_idle() const { return operations_.empty(); }
    [[nodiscard]] std::uint32_t dropped() const { return dropped_; }

protected:
    struct Storage {
        MutableBytes queue;
        std::span<TopicTable::Entry> topics;
        std::span<char> names;
        std::span<mqttsn::MsgId> unreleased;
        std::size_t datagram_octets;
    };
    ClientCore(const Storage& storage, const Timing& timing, std::uint64_t seed);
    ~ClientCore() = default;

private:
    /// One call of this client: its time, and where its output goes.
    struct Call {
        Instant now;
        Output& out;
    };

    // connection.cpp
    void begin_connect_step(mqttsn::MsgType step, const Call& call);
    void send_connect_step(Output& out);
    void on_will_prompt(mqttsn::MsgType prompt, const Call& call);
    void on_connack(mqttsn::ReturnCode code, const Call& call);
    void send_disconnect(Output& out);
    void on_disconnect(const Call& call);
    void become_disconnected(const Event& why, Output& out);
    void stop_timers();

    // registering.cpp
    void begin_register(const Call& call);
    void on_register(mqttsn::Body& message, Output& out);

    // publishing.cpp
    [[nodiscard]] bool leaves_at_once(Instant now, mqttsn::Qos qos) const;
    [[nodiscard]] mqttsn::TopicId publish_topic_id(mqttsn::TopicIdType type,
                                                   std::string_view topic) const;
    void begin_publish(const Call& call);
    void on_puback_of_qos0(const mqttsn::Body& message, const Call& call);

    // subscribing.cpp
    void begin_subscribe(const Call& call);

    // receiving.cpp
    void on_publish(mqttsn::Body& message, const Call& call);
    [[nodiscard]] bool remember_unreleased(mqttsn::MsgId msg_id);
    void forget_unreleased(mqttsn::MsgId msg_id);
    void on_pubrel(const mqttsn::Body& message, Output& out);
    [[nodiscard]] bool is_receiving() const;

    // cell.cpp
    void on_cell_publish(const mqttsn::Body& message, const Call& call);
    void answer_cell(Output& out);

    // keep_alive.cpp
    void on_sign_of_life(Instant now);
    [[nodiscard]] static Duration before_end_of(KeepAlive period);
    void tick_keep_alive(const Call& call);
    void on_pingreq(Output& out);
    void on_pingresp(const Call& call);

    // sleeping.cpp
    void begin_collecting(const Call& call);
    void fall_asleep(const Call& call);

    // client.cpp
    void dispatch(mqttsn::MsgType type, mqttsn::Body& message, const Call& call);
    void drop() { ++dropped_; }
    void start_exchange(Instant now);
    void repeat_request(Output& out);
    void give_up(const Call& call);

    // turns.cpp: the operations one after the other
    Result<OperationId, Refusal> request(mqttsn::MsgType request, const mqttsn::TopicRef& topic,
                                         Bytes data, const PublishOptions& options,
                                         const Call& call);
    Result<OperationId, Refusal> enqueue(Operation operation, std::string_view name, Bytes data,
                                         const Call& call);
    void carry_on(const Call& call);
    void begin_front(const Call& call);
    void send_first(mqttsn::MsgType type, mqttsn::MsgId msg_id, const Call& call);
    void send_front(bool dup, Output& out);
    void resume_front(const Call& call);
    void postpone_front();
    void finish_front(const Event& event, Output& out);
    void fail_front(mqttsn::ReturnCode code, Output& out);
    void pause(const Call& call);

    // answers.cpp: to the front operation
    [[nodiscard]] bool is_awaited(mqttsn::MsgType answer, mqttsn::MsgId msg_id) const;
    void on_answer(mqttsn::MsgType type, const mqttsn::Body& message, const Call& call);
    void on_acceptance(mqttsn::MsgType type, const mqttsn::Body& message, const Call& call);
    [[nodiscard]] bool is_paused(Instant now) const { return now < paused_until_; }
    [[nodiscard]] mqttsn::MsgId next_msg_id();
    [[nodiscard]] OperationId next_operation() { return OperationId{++last_operation_}; }
    /// What fits into the long form of PUBLISH; other messages have less around it.
    [[nodiscard]] std::size_t most_data() const { return datagram_octets_ - 9; }

    // The small and busy ones first: a Cortex-M3 reaches the first octets of a class with its short
    // instructions.
    State state_ = State::disconnected;
    mqttsn::MsgType connect_step_{};  // CONNECT, WILLTOPIC or WILLMSG
    bool listens_ = false;            // to the broker's cell
    bool unfinished_ = false;         // the last Output was too small for all that could be sent
    std::uint16_t queued_qos0_ = 0;   // while one waits, later ones wait behind it
    std::uint16_t sleep_duration_s_ = 0;  // of DISCONNECT; 0 when it is not for a sleep
    std::uint16_t last_msg_id_;
    std::uint16_t last_operation_ = 0;
    std::uint32_t dropped_ = 0;

    OperationQueue operations_;
    RetryTimer exchange_;  // of connecting, of the front operation, of collecting...
    Instant ping_due_ = never;
    RetryTimer ping_;                        // of a keep-alive PINGREQ, beside the exchange
    Instant cell_answer_at_ = never;         // PUBACK to what came by the cell is due
    Instant collect_due_ = never;            // asleep: the next PINGREQ with client id
    Instant paused_until_ = Instant::min();  // T_WAIT after "congestion"

    struct {
        mqttsn::TopicId topic_id;
        mqttsn::MsgId msg_id;
    } cell_answer_{};
    mqttsn::MsgId last_taken_ = mqttsn::no_msg_id;  // of QoS 1 or 2, from the broker

    Timing timing_;
    TopicTable topics_;
    std::span<mqttsn::MsgId> unreleased_;  // QoS 2 received, oldest first; PUBREL has not come
    std::size_t unreleased_count_ = 0;
    std::size_t datagram_octets_;
    ConnectOptions options_;
};

/// A client with its storage. It stays where it was made.
template <typename Limits = HostLimits>
class Client final : public ClientCore {
public:
    explicit Client(const Timing& timing = {}, std::uint64_t seed = 0)
        : ClientCore({queue_, topics_, names_, unreleased_, Limits::datagram_octets}, timing,
                     seed) {}

private:
    std::uint8_t queue_[Limits::queue_octets];
    TopicTable::Entry topics_[Limits::topics];
    char names_[Limits::name_octets];
    mqttsn::MsgId unreleased_[Limits::unreleased];
};

}  // namespace romano::client
