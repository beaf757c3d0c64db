// libmosquitto on a thread of its own: names are resolved, connections made and lost without the
// broker's thread waiting for it. What happens is posted to the broker's io_context.
//
// What comes at QoS 1 is acknowledged to the MQTT broker only after acknowledge(token): in its
// threaded mode libmosquitto writes the PUBACK after the message callback has returned, and the
// callback waits. So a leader that dies has acknowledged nothing that only it knew. Subscriptions
// are of QoS 1 at most: of QoS 2 libmosquitto keeps in its own memory what a new leader would need.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "broker/uplink/mqtt/mqtt_settings.h"
#include "broker/uplink/uplink_core.h"

struct mosquitto;
struct mosquitto_message;

namespace romano::uplink {

/// Called on the broker's thread.
struct MqttEvents {
    std::function<void(bool resumed)> on_up;
    std::function<void(const std::string& why)> on_down;
    std::function<void(int packet_id, Answer)> on_answer;
    std::function<void(const FromRemote&, std::uint64_t token)> on_message;
};

class MqttThread : public std::enable_shared_from_this<MqttThread> {
public:
    MqttThread(boost::asio::io_context& io, MqttSettings settings, MqttEvents events);
    ~MqttThread();
    MqttThread(const MqttThread&) = delete;
    MqttThread& operator=(const MqttThread&) = delete;

    void start();
    /// No event comes after this. The thread ends by itself, in its own time.
    void stop();

    /// The packet id, or 0 when it could not be taken.
    int publish(const PublishUp& message);
    void acknowledge(std::uint64_t token);
    /// The thread has ended, or did not within this time.
    bool wait_until_ended(std::chrono::milliseconds limit);

private:
    void run();
    void serve();
    void rest(std::chrono::milliseconds time);
    template <typename Event>
    void tell(Event event);
    void on_connected(int reason, bool resumed);
    void on_answer(int packet_id, int reason);
    void on_message(const mosquitto_message& message, std::string identity, mqttsn::Qos qos);

    boost::asio::io_context& io_;
    const MqttSettings settings_;
    MqttEvents events_;  // the broker's thread only
    mosquitto* mosquitto_ = nullptr;

    std::mutex mutex_;
    std::condition_variable changed_;
    bool stopping_ = false;
    bool ended_ = false;
    std::uint64_t last_token_ = 0;
    std::uint64_t acknowledged_ = 0;  // of the tokens, which count up
    bool connected_ = false;          // its own thread only
    bool resumed_ = false;            // likewise
    bool replaced_ = false;           // likewise: another broker has our session
    std::string trouble_;             // likewise: why the last connection ended
};

}  // namespace romano::uplink
