// An unmodified MQTT-SN client for tests: one socket, one broker address, the exchanges of the
// specification step by step. It answers what a conforming client answers (REGACK, PUBACK, PUBREC,
// PUBCOMP) while it waits for something, and repeats what is not answered.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "romano/base/endpoint.h"
#include "romano/keys/client_packets.h"
#include "romano/mqttsn/messages.h"

namespace romano::system {

struct ReceivedPublish {
    std::string topic;
    std::string data;
    mqttsn::Qos qos = mqttsn::Qos::at_most_once;
    bool retain = false;
    bool dup = false;
};

struct KeyFile {
    std::filesystem::path path;
};

class TestClient {
public:
    TestClient(const Endpoint& local, const Endpoint& broker, std::string client_id);
    /// A client whose packets are protected.
    TestClient(const Endpoint& local, const Endpoint& broker, const KeyFile& key);
    ~TestClient();
    TestClient(const TestClient&) = delete;
    TestClient& operator=(const TestClient&) = delete;

    // Each is a whole exchange; false when it was refused or not answered in time.
    bool connect(bool clean_session = true);
    bool subscribe(const std::string& filter, mqttsn::Qos qos);
    std::optional<mqttsn::TopicId> register_topic(const std::string& topic);
    bool publish(mqttsn::TopicId topic, const std::string& data, mqttsn::Qos qos,
                 bool retain = false);
    bool ping();
    bool disconnect();

    /// Serves the socket until `done` or the deadline; true when done.
    bool run_until(const std::function<bool()>& done,
                   std::chrono::milliseconds limit = std::chrono::milliseconds{20'000});

    /// Shorter than the specification's Tretry, so that tests are short.
    std::chrono::milliseconds repeats_after{1000};

    void set_client_id(std::string id) { client_id_ = std::move(id); }
    /// As a datagram that this client would send.
    [[nodiscard]] std::vector<std::uint8_t> sealed(const mqttsn::Message& message);
    /// Any octets, to the broker.
    void send_octets(Bytes octets);
    /// What was sent last, as it went out.
    [[nodiscard]] const std::vector<std::uint8_t>& last_sent() const { return last_sent_; }

    /// Deliveries so far. QoS 2 ones count once.
    std::vector<ReceivedPublish> received;
    /// Messages by which a client would notice a new broker: CONNACK, SUBACK, DISCONNECT.
    int sessions_begun = 0;

private:
    using Matches = std::function<bool(const mqttsn::Message&)>;

    bool exchange(const mqttsn::Message& request, const Matches& answered,
                  const std::function<mqttsn::Message()>& repetition = {});
    void send(const mqttsn::Message& message);
    bool receive(std::chrono::milliseconds limit);
    void handle(const mqttsn::Message& message);
    void handle_publish(const mqttsn::Publish& publish);
    [[nodiscard]] std::string topic_name(const mqttsn::Publish& publish) const;
    mqttsn::MsgId next_msg_id();

    void open_socket(const Endpoint& local, const Endpoint& broker);

    int socket_ = -1;
    std::unique_ptr<keys::ClientPackets> packets_;  // null: plain
    std::vector<std::uint8_t> last_sent_;
    std::string client_id_;
    std::uint16_t last_msg_id_ = 0;
    std::map<mqttsn::TopicId, std::string> topics_;
    std::map<mqttsn::MsgId, ReceivedPublish> unreleased_;
    std::vector<std::uint8_t> buffer_;
    const Matches* waiting_for_ = nullptr;
    bool answered_ = false;
};

}  // namespace romano::system
