// A plain MQTT 5 client (libmosquitto) for experiments and tests: what somebody on the internet
// uses, who knows nothing of ROMANO.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/mqtt/mosquitto_server.h"

namespace romano::experiments {

struct MqttMessage {
    std::string topic;
    std::string payload;
    int qos = 0;
    bool retain = false;
    std::string identity;  // the user property romano-id, or empty
};

class MqttClient {
public:
    /// Throws std::runtime_error when it is not connected within ten seconds.
    MqttClient(const MosquittoServer& server, const std::string& address,
               const std::string& client_id);
    ~MqttClient();
    MqttClient(const MqttClient&) = delete;
    MqttClient& operator=(const MqttClient&) = delete;

    /// Returns when the MQTT broker has confirmed it.
    void subscribe(const std::string& filter, int qos);
    void publish(const std::string& topic, const std::string& payload, int qos,
                 bool retain = false);

    [[nodiscard]] std::vector<MqttMessage> received() const;
    /// Of QoS 1 and 2: how many the MQTT broker has confirmed.
    [[nodiscard]] std::size_t confirmed() const;
    bool wait_until(const std::function<bool()>& done,
                    std::chrono::milliseconds limit = std::chrono::seconds{20}) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace romano::experiments
