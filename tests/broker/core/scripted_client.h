// Clients that speak by script to a broker core in virtual time: tests read like sequence charts.
//
//     ScriptedBroker broker;
//     ScriptedClient robot{broker, "robot"};
//     robot.connects();
//     robot.says(Register{no_topic_id, MsgId{1}, "pose"});
//     const auto ack = robot.hears<Regack>();
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <variant>
#include <vector>

#include "broker/core/broker_core.h"
#include "broker/core/mirror.h"
#include "romano/mqttsn/codec.h"

namespace romano::broker {

using namespace std::chrono_literals;
using namespace romano::mqttsn;  // the messages' names, as in the specification
using MqttsnMessage = mqttsn::Message;
using Octets = std::vector<std::uint8_t>;

inline Endpoint loopback(std::uint8_t host, std::uint16_t port) {
    return {.address = {127, 0, 0, host}, .port = port, .family = Endpoint::Family::ipv4};
}

inline Octets octets_of(std::string_view text) {
    return {text.begin(), text.end()};
}

inline BrokerOptions plain_options() {
    BrokerOptions options;
    options.log = {broker_id_of("b1"), 1};
    options.advertise_every = Duration{0};
    options.predefined_topics = {{TopicId{7}, "predefined/seven"}};
    return options;
}

inline BrokerOptions logging_options() {
    BrokerOptions options = plain_options();
    options.writes_log = true;
    return options;
}

/// True for what names a client: after it, an address may have another order of datagrams.
inline bool may_bring_another_session(const Octets& datagram) {
    const std::size_t wrapping = datagram.size() > 1 && datagram[1] == 0xFE ? datagram[0] : 0U;
    if (datagram.size() < wrapping + 2) return false;
    switch (MsgType{datagram[wrapping + 1]}) {
        case MsgType::connect:
        case MsgType::willtopic:
        case MsgType::willmsg:
        case MsgType::pingreq:
            return true;
        default:
            return false;
    }
}

/// A broker core, its time, and where its actions went.
class ScriptedBroker {
public:
    explicit ScriptedBroker(const BrokerOptions& options = plain_options())
        : core(options, 1), via(loopback(1, 1883)), mirror(options.log) {}

    void receives(const ClientAddress& from, const Octets& datagram) {
        receives({via, from}, datagram);
    }
    void receives(const Origin& origin, const Octets& datagram) {
        core.on_datagram(now, origin.via, origin.from.endpoint, datagram, actions);
        if (may_bring_another_session(datagram)) floors.erase(origin);
        drain();
    }

    void waits(Duration duration) {
        const Instant end = now + duration;
        while (core.next_wakeup() <= end) {
            now = std::max(now, core.next_wakeup());
            core.on_tick(now, actions);
            drain();
        }
        now = end;
    }

    void drain() {
        for (Action& action : actions.list()) {
            if (const auto* send = std::get_if<Send>(&action)) {
                const Bytes octets = actions.octets(*send);
                // Only a stranger's DISCONNECT belongs to no session's order.
                const bool is_disconnect = octets.back() == 0x18;
                const Origin client{send->via, send->to};
                EXPECT_TRUE(is_disconnect || send->after >= floors[client])
                    << "a datagram overtakes an earlier one";
                floors[client] = send->after;
                inboxes[client].emplace_back(octets.begin(), octets.end());
                last_after = send->after;
            } else if (const auto* multicast = std::get_if<Multicast>(&action)) {
                const Bytes octets = actions.octets(*multicast);
                multicasts.emplace_back(octets.begin(), octets.end());
            } else if (const auto* append = std::get_if<Append>(&action)) {
                EXPECT_EQ(append->seq, log.size() + 1);
                log.push_back(*append->event);
            } else if (auto* observed = std::get_if<Observed>(&action)) {
                observations.push_back(std::move(*observed->what));
            } else if (auto* note = std::get_if<Note>(&action)) {
                notes.push_back(std::move(*note->text));
            } else {
                forwards.push_back(std::get<Forward>(action).message);
            }
        }
        actions.clear();
        core.check_invariants();
    }

    /// What a peer that applied the whole log holds, against what the home holds.
    void expects_mirror_to_agree() {
        core.append_cursors(actions);
        drain();
        for (; mirror.applied() < log.size();) {
            mirror.apply(mirror.applied() + 1, log[mirror.applied()]);
        }
        const auto at_home = core.images();
        const auto mirrored = mirror.images();
        ASSERT_EQ(at_home.size(), mirrored.size());
        for (std::size_t i = 0; i < at_home.size(); ++i) {
            EXPECT_TRUE(same_state(at_home[i], mirrored[i])) << at_home[i].header.client_id;
        }
    }

    [[nodiscard]] LogId core_log() const { return mirror.log(); }

    [[nodiscard]] std::uint64_t dropped(Drop reason) const {
        return core.counters().dropped[static_cast<std::size_t>(reason)];
    }

    BrokerCore core;
    Endpoint via;
    Instant now{1s};
    Actions actions;
    std::unordered_map<Origin, std::deque<Octets>, OriginHash> inboxes;
    std::unordered_map<Origin, Seq, OriginHash> floors;
    std::vector<Octets> multicasts;
    std::vector<LogEvent> log;  // event n at n - 1
    std::vector<MessagePtr> forwards;
    std::vector<Observation> observations;
    std::vector<std::string> notes;  // warnings for people
    Seq last_after = 0;
    Mirror mirror;
};

class ScriptedClient {
public:
    ScriptedClient(ScriptedBroker& at, std::string client_id, std::uint16_t port = 0)
        : id(std::move(client_id)), via(at.via), broker_(&at) {
        static std::uint16_t next_port = 20'000;
        address.endpoint = loopback(2, port != 0 ? port : next_port++);
    }

    /// From now on another broker answers at the address that the client talks to.
    void moves_to(ScriptedBroker& other) {
        auto& inbox = other.inboxes[Origin{via, address}];
        auto& old = broker_->inboxes[Origin{via, address}];
        inbox.insert(inbox.begin(), old.begin(), old.end());
        old.clear();
        broker_ = &other;
    }

    template <typename M>
    void says(const M& message) {
        says_octets(encoded(message));
    }
    void says_octets(Octets octets) {
        if (!address.wireless_node_id.empty()) {
            octets = encoded(Encapsulated{.radius = 1,
                                          .wireless_node_id = as_octets(address.wireless_node_id),
                                          .message = octets});
        }
        broker_->receives({via, address}, octets);
    }

    /// The next datagram to this client, which must be an M. Views live until the next one.
    template <typename M>
    M hears() {
        const MqttsnMessage* message = next();
        if (message == nullptr) {
            ADD_FAILURE() << id << " hears nothing instead of " << name_of(M::type);
            return M{};
        }
        const M* expected = std::get_if<M>(message);
        if (expected == nullptr) {
            ADD_FAILURE() << id << " hears " << name_of(type_of(*message)) << " instead of "
                          << name_of(M::type);
            return M{};
        }
        return *expected;
    }

    /// The next datagram, or null.
    const MqttsnMessage* next() {
        auto& inbox = broker_->inboxes[Origin{via, address}];
        if (inbox.empty()) return nullptr;
        heard_ = std::move(inbox.front());
        inbox.pop_front();
        auto decoded = mqttsn::decode(heard_);
        if (const auto* frame = decoded ? std::get_if<Encapsulated>(&*decoded) : nullptr) {
            EXPECT_EQ(as_text(frame->wireless_node_id), address.wireless_node_id);
            decoded = mqttsn::decode(frame->message);
        }
        EXPECT_TRUE(decoded.has_value()) << "malformed octets from the broker";
        if (!decoded) return nullptr;
        message_ = *decoded;
        return &message_;
    }

    void hears_nothing() {
        const MqttsnMessage* message = next();
        EXPECT_EQ(message, nullptr) << id << " hears " << name_of(type_of(*message));
    }

    [[nodiscard]] std::size_t unheard() const {
        return broker_->inboxes[Origin{via, address}].size();
    }
    void ignores_what_came() { broker_->inboxes[Origin{via, address}].clear(); }

    void connects(bool clean_session = true, std::uint16_t keep_alive_s = 0) {
        says(connect(clean_session, keep_alive_s));
        EXPECT_EQ(hears<Connack>().return_code, ReturnCode::accepted);
    }
    [[nodiscard]] Connect connect(bool clean_session = true, std::uint16_t keep_alive_s = 0,
                                  bool will = false) const {
        return {will, clean_session, protocol_id, keep_alive_s, id};
    }

    TopicId registers(std::string_view name) {
        says(Register{no_topic_id, next_msg_id(), name});
        const auto ack = hears<Regack>();
        EXPECT_EQ(ack.return_code, ReturnCode::accepted);
        return ack.topic_id;
    }

    TopicId subscribes(std::string_view filter, Qos qos = Qos::exactly_once) {
        says(Subscribe{false, qos, next_msg_id(), {TopicIdType::normal, filter, no_topic_id}});
        const auto ack = hears<Suback>();
        EXPECT_EQ(ack.return_code, ReturnCode::accepted);
        EXPECT_EQ(ack.qos, qos);
        return ack.topic_id;
    }

    /// Publishes at QoS 0, 1 or 2 by id and goes through the exchange.
    void publishes(TopicId topic, std::string_view data, Qos qos = Qos::at_most_once,
                   bool retain = false) {
        const MsgId msg_id = qos == Qos::at_most_once ? no_msg_id : next_msg_id();
        says(Publish{false, qos, retain, TopicIdType::normal, topic, msg_id, as_octets(data)});
        if (qos == Qos::at_least_once) {
            EXPECT_EQ(hears<Puback>().return_code, ReturnCode::accepted);
        } else if (qos == Qos::exactly_once) {
            EXPECT_EQ(hears<Pubrec>().msg_id, msg_id);
            says(Pubrel{msg_id});
            EXPECT_EQ(hears<Pubcomp>().msg_id, msg_id);
        }
    }

    /// The next datagram is this PUBLISH; acknowledges it to the end.
    Publish hears_publish(std::string_view data, Qos qos = Qos::at_most_once) {
        const auto publish = hears<Publish>();
        EXPECT_EQ(as_text(publish.data), data);
        EXPECT_EQ(publish.qos, qos);
        if (qos == Qos::at_least_once) {
            says(Puback{publish.topic, publish.msg_id, ReturnCode::accepted});
        } else if (qos == Qos::exactly_once) {
            const MsgId msg_id = publish.msg_id;
            says(Pubrec{msg_id});
            EXPECT_EQ(hears<Pubrel>().msg_id, msg_id);
            says(Pubcomp{msg_id});
        }
        return publish;
    }

    /// The next datagram tells this name's topic id; the client takes it.
    TopicId hears_register(std::string_view name) {
        const auto told = hears<Register>();
        EXPECT_EQ(told.topic_name, name);
        says(Regack{told.topic_id, told.msg_id, ReturnCode::accepted});
        return told.topic_id;
    }

    MsgId next_msg_id() { return MsgId{++last_msg_id_}; }

    template <typename M>
    static Octets encoded(const M& message) {
        Octets octets(65'600);
        octets.resize(mqttsn::encode(message, octets));
        return octets;
    }

    std::string id;
    Endpoint via;  // the service address that it talks to, and listens to
    ClientAddress address;

private:
    ScriptedBroker* broker_;
    Octets heard_;
    MqttsnMessage message_;
    std::uint16_t last_msg_id_ = 0;
};

}  // namespace romano::broker
