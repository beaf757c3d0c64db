// A scripted MQTT-SN client for tests: talks to one fixed address, answers what a conforming client
// answers, asks again what is not answered, and writes down what it got.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "romano/base/endpoint.h"
#include "romano/base/time.h"
#include "romano/mqttsn/codec.h"

namespace romano::test {

class Robot {
public:
    using Sender = std::function<void(const Endpoint& from, const Endpoint& to, Bytes)>;

    Robot(std::string name, Endpoint self, Endpoint broker, Sender sender)
        : name_(std::move(name)), self_(self), broker_(broker), sender_(std::move(sender)) {}

    void connect(bool clean = true);
    /// A will of QoS 2: the robot's name on that topic.
    void connect_with_will(const std::string& topic, std::uint16_t keep_alive_s);
    void disconnect() { send(mqttsn::Disconnect{}); }
    void subscribe(const std::string& topic, mqttsn::Qos qos);
    void publish(const std::string& topic, const std::string& text, mqttsn::Qos qos,
                 bool retain = false);
    void search() { send(mqttsn::Searchgw{}); }
    /// QoS 1, under a topic id that robot and broker know without words.
    void publish_predefined(mqttsn::TopicId predefined, const std::string& text);
    /// QoS -1.
    void publish_without_connection(mqttsn::TopicId predefined, const std::string& text);
    /// Talks to another broker from now on.
    void move_to(Endpoint broker) { broker_ = broker; }

    void on_datagram(Bytes datagram);
    void on_tick(Instant now);

    [[nodiscard]] const Endpoint& self() const { return self_; }
    [[nodiscard]] const Endpoint& broker() const { return broker_; }
    /// Payloads as they reached the application, in order.
    [[nodiscard]] const std::vector<std::string>& received() const { return received_; }
    [[nodiscard]] std::size_t acknowledged() const { return acknowledged_; }
    [[nodiscard]] int count_sent(mqttsn::MsgType type) const {
        const auto found = sent_.find(type);
        return found == sent_.end() ? 0 : found->second;
    }
    /// DISCONNECTs from the broker: it did not know us.
    [[nodiscard]] int rejections() const { return rejections_; }
    [[nodiscard]] std::set<mqttsn::TopicId> topic_ids_seen() const { return topic_ids_seen_; }

private:
    struct Request {
        mqttsn::MsgType type{};
        std::string topic{};
        std::string text{};
        mqttsn::Qos qos{};
        bool flag = false;  // clean session, or retain
        mqttsn::TopicId predefined{};
        mqttsn::MsgId msg_id{};
        bool sent = false;
        bool released = false;  // PUBREC is here: PUBREL goes out
        Instant again_at{};
    };

    void ask(Request request);
    void send_front();
    void done();
    void send(const mqttsn::Message& message);
    void on_publish(const mqttsn::Publish& publish);

    std::string name_;
    Endpoint self_;
    Endpoint broker_;
    Sender sender_;
    Instant now_{};
    std::deque<Request> requests_;
    std::uint16_t keep_alive_s_ = 60;
    std::uint16_t last_msg_id_ = 0;
    std::map<std::string, mqttsn::TopicId> topic_ids_;
    std::set<mqttsn::MsgId> unreleased_;
    std::set<mqttsn::TopicId> topic_ids_seen_;
    std::vector<std::string> received_;
    std::map<mqttsn::MsgType, int> sent_;
    std::size_t acknowledged_ = 0;
    int rejections_ = 0;
};

}  // namespace romano::test
