// Clients that do anything at any time, drawn from a seed: for what must hold whatever they do.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "romano/base/random.h"
#include "tests/broker/core/scripted_client.h"

namespace romano::broker {

/// Whether messages of other brokers come too.
enum class Peers : std::uint8_t { none, some };

class RandomClients {
public:
    RandomClients(ScriptedBroker& broker, std::uint64_t seed, std::size_t count,
                  Peers peers = Peers::some)
        : broker_(broker), random_(seed), peers_(peers) {
        for (std::size_t i = 0; i < count; ++i) {
            clients_.push_back(std::make_unique<ScriptedClient>(
                broker, "c" + std::to_string(i), static_cast<std::uint16_t>(30'000 + i)));
            if (i % 4 == 3) clients_.back()->address.wireless_node_id = "n" + std::to_string(i);
        }
    }

    void step() {
        ScriptedClient& client = *clients_[pick(clients_.size())];
        switch (pick(20)) {
            case 0:
                client.says(client.connect(pick(2) == 0, static_cast<std::uint16_t>(pick(3) * 20),
                                           pick(3) == 0));
                break;
            case 1:
                client.says(Disconnect{pick(2) == 0, static_cast<std::uint16_t>(pick(60))});
                break;
            case 2:
                client.says(Pingreq{pick(2) == 0 ? client.id : std::string_view{}});
                break;
            case 3:
                client.says(Register{no_topic_id, msg_id(), name()});
                break;
            case 4:
            case 5:
                client.says(Subscribe{false, qos(), msg_id(), topic_ref()});
                break;
            case 6:
                client.says(Unsubscribe{msg_id(), topic_ref()});
                break;
            case 7:
            case 8:
            case 9:
                client.says(Publish{pick(4) == 0, qos(), pick(4) == 0, TopicIdType{pick8(3)},
                                    topic_id(), msg_id(), as_octets(pick(5) == 0 ? "" : "data")});
                break;
            case 10:
                client.says(Pubrel{msg_id()});
                break;
            case 11:
                client.says(Willtopicupd{qos(), pick(2) == 0, name()});
                break;
            case 12:
                client.says(Willmsgupd{as_octets("will")});
                break;
            case 13:
                broker_.waits(std::chrono::seconds{pick(30)});
                break;
            case 14:
                client.address.endpoint.port = static_cast<std::uint16_t>(30'000 + pick(20));
                break;
            case 15:
                if (peers_ == Peers::some) hears_from_a_peer();
                break;
            default:
                answers(client);
                break;
        }
    }

private:
    std::uint32_t pick(std::size_t below) {
        return random_.below(static_cast<std::uint32_t>(below));
    }
    std::uint8_t pick8(std::size_t below) { return static_cast<std::uint8_t>(pick(below)); }
    MsgId msg_id() { return MsgId{static_cast<std::uint16_t>(pick(6))}; }
    Qos qos() { return Qos{pick8(4)}; }
    std::string_view name() {
        static const std::vector<std::string> names = {"a", "a/b", "a/c", "ab", "b", "b/c/d"};
        return names[pick(names.size())];
    }
    TopicId topic_id() {
        return pick(3) == 0 ? TopicId{0x6162} : TopicId{static_cast<std::uint16_t>(pick(9))};
    }
    TopicRef topic_ref() {
        static const std::vector<std::string> filters = {"#", "a/+", "+", "a/#", "b/+/d"};
        switch (pick(4)) {
            case 0:
                return {TopicIdType::normal, filters[pick(filters.size())], no_topic_id};
            case 1:
                return {TopicIdType::short_name, "ab", no_topic_id};
            case 2:
                return {TopicIdType::predefined, {}, TopicId{7}};
            default:
                return {TopicIdType::normal, name(), no_topic_id};
        }
    }

    /// Answers what the client was sent, or loses it, or answers something else.
    void answers(ScriptedClient& client) {
        while (client.unheard() != 0) {
            const MqttsnMessage* heard = client.next();
            if (heard == nullptr || pick(4) == 0) continue;
            const auto code = pick(8) == 0 ? ReturnCode{pick8(4)} : ReturnCode::accepted;
            if (const auto* m = std::get_if<Register>(heard)) {
                client.says(Regack{m->topic_id, m->msg_id, code});
            } else if (const auto* publish = std::get_if<Publish>(heard)) {
                if (publish->qos == Qos::exactly_once && code == ReturnCode::accepted) {
                    client.says(Pubrec{publish->msg_id});
                } else {
                    client.says(Puback{publish->topic, publish->msg_id, code});
                }
            } else if (const auto* rel = std::get_if<Pubrel>(heard)) {
                client.says(Pubcomp{rel->msg_id});
            } else if (std::holds_alternative<Willtopicreq>(*heard)) {
                client.says(Willtopic{qos(), pick(2) == 0, pick(3) == 0 ? "" : name()});
            } else if (std::holds_alternative<Willmsgreq>(*heard)) {
                client.says(Willmsg{as_octets("gone")});
            } else if (std::holds_alternative<Pingreq>(*heard)) {
                client.says(Pingresp{});
            }
        }
    }

    void hears_from_a_peer() {
        const LogId peer{broker_id_of(pick(2) == 0 ? "p1" : "p2"), 1};
        Seq& seq = peer_seq_[peer];
        const Qos published = Qos{pick8(3)};
        const bool retain = pick(3) == 0;
        const bool in_log = published != Qos::at_most_once || retain;
        if (in_log) seq += 1 + pick(3);
        const MessagePtr message{Message{.topic = std::string{name()},
                                         .payload = octets_of(pick(5) == 0 ? "" : "peer"),
                                         .qos = published,
                                         .retain = retain,
                                         .position = {peer, in_log ? seq : 0},
                                         .published_at = {std::uint64_t{pick(1000)} << 16U}}};
        broker_.core.on_peer_message(broker_.now, message, broker_.actions);
        broker_.drain();
    }

    ScriptedBroker& broker_;
    Random random_;
    Peers peers_;
    std::vector<std::unique_ptr<ScriptedClient>> clients_;
    std::map<LogId, Seq> peer_seq_;
};

}  // namespace romano::broker
