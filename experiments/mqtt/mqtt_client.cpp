#include "experiments/mqtt/mqtt_client.h"

#include <mosquitto.h>
#include <mqtt_protocol.h>

#include <cstdlib>
#include <mutex>
#include <stdexcept>
#include <string_view>
#include <thread>

namespace romano::experiments {

using namespace std::chrono_literals;

struct MqttClient::State {
    mosquitto* client = nullptr;
    mutable std::recursive_mutex mutex{};  // wait_until() asks under it
    std::vector<MqttMessage> received{};
    std::size_t confirmed = 0;
    std::size_t subscribed = 0;
    bool connected = false;
};

namespace {

constexpr int receive_maximum = 65'535;

std::string identity_in(const mosquitto_property* properties) {
    char* name = nullptr;
    char* value = nullptr;
    std::string found;
    const auto* at = mosquitto_property_read_string_pair(properties, MQTT_PROP_USER_PROPERTY, &name,
                                                         &value, false);
    while (at != nullptr) {
        if (std::string_view{name} == "romano-id") found = value;
        std::free(name);
        std::free(value);
        at = mosquitto_property_read_string_pair(at, MQTT_PROP_USER_PROPERTY, &name, &value, true);
    }
    return found;
}

}  // namespace

MqttClient::MqttClient(const MosquittoServer& server, const std::string& address,
                       const std::string& client_id)
    : state_(std::make_unique<State>()) {
    static const int library = mosquitto_lib_init();
    (void)library;
    State& state = *state_;
    state.client = mosquitto_new(client_id.c_str(), true, &state);
    mosquitto_int_option(state.client, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
    // mosquitto 2.0.11 sends more at QoS 2 than the 20 that libmosquitto lets it unless told.
    mosquitto_int_option(state.client, MOSQ_OPT_RECEIVE_MAXIMUM, receive_maximum);
    mosquitto_username_pw_set(state.client, MosquittoServer::username, MosquittoServer::password);
    if (server.has_tls()) {
        mosquitto_tls_set(state.client, server.ca_file().c_str(), nullptr, nullptr, nullptr,
                          nullptr);
    }
    static const auto state_of = [](void* object) -> State& {
        return *static_cast<State*>(object);
    };
    mosquitto_connect_v5_callback_set(state.client,
                                      [](mosquitto*, void* object, int reason, int, const auto*) {
                                          const std::lock_guard lock(state_of(object).mutex);
                                          state_of(object).connected = reason == 0;
                                      });
    mosquitto_subscribe_v5_callback_set(
        state.client, [](mosquitto*, void* object, int, int, const int*, const auto*) {
            const std::lock_guard lock(state_of(object).mutex);
            ++state_of(object).subscribed;
        });
    mosquitto_publish_v5_callback_set(state.client,
                                      [](mosquitto*, void* object, int, int, const auto*) {
                                          const std::lock_guard lock(state_of(object).mutex);
                                          ++state_of(object).confirmed;
                                      });
    mosquitto_message_v5_callback_set(
        state.client,
        [](mosquitto*, void* object, const mosquitto_message* message, const auto* properties) {
            const std::lock_guard lock(state_of(object).mutex);
            state_of(object).received.push_back(
                {.topic = message->topic,
                 .payload = {static_cast<const char*>(message->payload),
                             static_cast<std::size_t>(message->payloadlen)},
                 .qos = message->qos,
                 .retain = message->retain,
                 .identity = identity_in(properties)});
        });
    mosquitto_loop_start(state.client);
    mosquitto_connect(state.client, address.c_str(), server.port(), 30);
    if (!wait_until([&] { return state.connected; }, 10s)) {
        throw std::runtime_error("no connection to mosquitto at " + address);
    }
}

MqttClient::~MqttClient() {
    mosquitto_disconnect(state_->client);
    mosquitto_loop_stop(state_->client, false);
    mosquitto_destroy(state_->client);
}

void MqttClient::subscribe(const std::string& filter, int qos) {
    std::size_t before = 0;
    {
        const std::lock_guard lock(state_->mutex);
        before = state_->subscribed;
    }
    mosquitto_subscribe(state_->client, nullptr, filter.c_str(), qos);
    if (!wait_until([&] { return state_->subscribed > before; })) {
        throw std::runtime_error("mosquitto does not confirm a subscription to " + filter);
    }
}

void MqttClient::publish(const std::string& topic, const std::string& payload, int qos,
                         bool retain) {
    mosquitto_publish_v5(state_->client, nullptr, topic.c_str(), static_cast<int>(payload.size()),
                         payload.data(), qos, retain, nullptr);
}

std::vector<MqttMessage> MqttClient::received() const {
    const std::lock_guard lock(state_->mutex);
    return state_->received;
}

std::size_t MqttClient::confirmed() const {
    const std::lock_guard lock(state_->mutex);
    return state_->confirmed;
}

bool MqttClient::wait_until(const std::function<bool()>& done,
                            std::chrono::milliseconds limit) const {
    const auto deadline = std::chrono::steady_clock::now() + limit;
    for (;;) {
        {
            const std::lock_guard lock(state_->mutex);
            if (done()) return true;
        }
        if (std::chrono::steady_clock::now() > deadline) return false;
        std::this_thread::sleep_for(5ms);
    }
}

}  // namespace romano::experiments
