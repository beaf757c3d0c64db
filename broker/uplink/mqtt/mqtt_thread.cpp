#include "broker/uplink/mqtt/mqtt_thread.h"

#include <mqtt_protocol.h>

// mqtt_protocol.h must stand first
#include <mosquitto.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

#include "broker/net/turn_clock.h"

namespace romano::uplink {
namespace {

using namespace std::chrono_literals;

constexpr int keep_alive_s = 15;
constexpr std::uint32_t session_kept_s = 24 * 60 * 60;
constexpr auto shortest_rest = 500ms;
constexpr auto longest_rest = 30'000ms;

constexpr int first_error = 0x80;  // of the reason codes, MQTT 5 §2.4

constexpr const char* identity_name = "romano-id";
constexpr const char* qos_name = "romano-qos";

/// The value of the user property, or empty.
std::string user_property(const mosquitto_property* properties, std::string_view wanted) {
    char* name = nullptr;
    char* value = nullptr;
    std::string found;
    const auto* at = mosquitto_property_read_string_pair(properties, MQTT_PROP_USER_PROPERTY, &name,
                                                         &value, false);
    while (at != nullptr) {
        if (name == wanted && found.empty()) found = value;
        std::free(name);
        std::free(value);
        at = mosquitto_property_read_string_pair(at, MQTT_PROP_USER_PROPERTY, &name, &value, true);
    }
    return found;
}

struct LibraryInUse {
    LibraryInUse() { mosquitto_lib_init(); }
};

}  // namespace

MqttThread::MqttThread(boost::asio::io_context& io, MqttSettings settings, MqttEvents events)
    : io_(io), settings_(std::move(settings)), events_(std::move(events)) {
    static const LibraryInUse library;
    mosquitto_ = mosquitto_new(settings_.client_id.c_str(), false, this);
    if (mosquitto_ == nullptr) throw std::runtime_error("--uplink: libmosquitto does not start");
    mosquitto_int_option(mosquitto_, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
    mosquitto_int_option(mosquitto_, MOSQ_OPT_TCP_NODELAY, 1);
    mosquitto_threaded_set(mosquitto_, true);
    if (!settings_.username.empty()) {
        mosquitto_username_pw_set(mosquitto_, settings_.username.c_str(),
                                  settings_.password.c_str());
    }
    if (settings_.tls) {
        int refused = MOSQ_ERR_SUCCESS;
        if (settings_.ca_file.empty()) {
            refused = mosquitto_int_option(mosquitto_, MOSQ_OPT_TLS_USE_OS_CERTS, 1);
        } else {
            refused = mosquitto_tls_set(mosquitto_, settings_.ca_file.c_str(), nullptr, nullptr,
                                        nullptr, nullptr);
        }
        if (refused != MOSQ_ERR_SUCCESS) {
            mosquitto_destroy(mosquitto_);
            throw std::runtime_error("--uplink-ca '" + settings_.ca_file + "': cannot be used (" +
                                     mosquitto_strerror(refused) + ")");
        }
    }
    static const auto self_of = [](void* object) { return static_cast<MqttThread*>(object); };
    mosquitto_connect_v5_callback_set(
        mosquitto_, [](mosquitto*, void* object, int reason, int flags, const auto*) {
            self_of(object)->on_connected(reason, (flags & 1) != 0);
        });
    mosquitto_disconnect_v5_callback_set(
        mosquitto_, [](mosquitto*, void* object, int reason, const auto*) {
            self_of(object)->replaced_ = reason == MQTT_RC_SESSION_TAKEN_OVER;
        });
    mosquitto_publish_v5_callback_set(
        mosquitto_, [](mosquitto*, void* object, int packet_id, int reason, const auto*) {
            self_of(object)->on_answer(packet_id, reason);
        });
    mosquitto_message_v5_callback_set(
        mosquitto_,
        [](mosquitto*, void* object, const mosquitto_message* message, const auto* properties) {
            const std::string qos = user_property(properties, qos_name);
            self_of(object)->on_message(*message, user_property(properties, identity_name),
                                        qos == "2" && message->qos == 1
                                            ? mqttsn::Qos::exactly_once
                                            : static_cast<mqttsn::Qos>(message->qos));
        });
    mosquitto_subscribe_v5_callback_set(
        mosquitto_, [](mosquitto*, void* object, int, int count, const int* granted, const auto*) {
            if (std::none_of(granted, granted + count, [](int qos) { return qos > 2; })) return;
            self_of(object)->tell(
                [](MqttEvents& told) { told.on_down("it refuses a subscription of ours"); });
        });
}

MqttThread::~MqttThread() {
    mosquitto_destroy(mosquitto_);
}

void MqttThread::start() {
    std::thread([self = shared_from_this()] { self->run(); }).detach();
}

void MqttThread::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    mosquitto_disconnect_v5(mosquitto_, MQTT_RC_NORMAL_DISCONNECTION, nullptr);
}

bool MqttThread::wait_until_ended(std::chrono::milliseconds limit) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, limit, [this] { return ended_; });
}

int MqttThread::publish(const PublishUp& message) {
    mosquitto_property* properties = nullptr;
    mosquitto_property_add_string_pair(&properties, MQTT_PROP_USER_PROPERTY, identity_name,
                                       message.identity.c_str());
    if (message.qos == mqttsn::Qos::exactly_once) {
        mosquitto_property_add_string_pair(&properties, MQTT_PROP_USER_PROPERTY, qos_name, "2");
    }
    int packet_id = 0;
    const auto& payload = message.message->payload;
    const int refused = mosquitto_publish_v5(
        mosquitto_, &packet_id, message.topic.c_str(), static_cast<int>(payload.size()),
        payload.data(), static_cast<int>(message.qos), message.message->retain, properties);
    mosquitto_property_free_all(&properties);
    return refused == MOSQ_ERR_SUCCESS ? packet_id : 0;
}

void MqttThread::acknowledge(std::uint64_t token) {
    {
        const std::lock_guard lock(mutex_);
        acknowledged_ = std::max(acknowledged_, token);
    }
    changed_.notify_all();
}

// --- its own thread

template <typename Event>
void MqttThread::tell(Event event) {
    // Under the lock: after stop() the io_context may be gone at any moment.
    const std::lock_guard posting(mutex_);
    if (stopping_) return;
    net::post_turn(io_, [self = shared_from_this(), event = std::move(event)] {
        {
            const std::lock_guard lock(self->mutex_);
            if (self->stopping_) return;
        }
        event(self->events_);
    });
}

void MqttThread::run() {
    auto pause = std::chrono::milliseconds{shortest_rest};
    const auto stops = [this] {
        const std::lock_guard lock(mutex_);
        return stopping_;
    };
    while (!stops()) {
        connected_ = replaced_ = false;
        trouble_.clear();
        serve();
        if (stops()) break;
        if (connected_) pause = shortest_rest;
        if (replaced_) {
            pause = longest_rest;
            trouble_ = "another broker of this network has taken the session";
        }
        tell([why = trouble_](MqttEvents& events) { events.on_down(why); });
        rest(pause);
        pause = std::min(2 * pause, std::chrono::milliseconds{longest_rest});
    }
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
    }
    changed_.notify_all();
}

/// One connection, from its beginning to its end.
void MqttThread::serve() {
    mosquitto_property* properties = nullptr;
    mosquitto_property_add_int32(&properties, MQTT_PROP_SESSION_EXPIRY_INTERVAL, session_kept_s);
    int error = mosquitto_connect_bind_v5(mosquitto_, settings_.host.c_str(), settings_.port,
                                          keep_alive_s, nullptr, properties);
    mosquitto_property_free_all(&properties);
    for (int last_turns = 3; error == MOSQ_ERR_SUCCESS && last_turns > 0;) {
        error = mosquitto_loop(mosquitto_, 1000, 1);
        const std::lock_guard lock(mutex_);
        if (!stopping_) continue;
        // Once more: a connection that has begun since stop() knows nothing of it.
        mosquitto_disconnect_v5(mosquitto_, MQTT_RC_NORMAL_DISCONNECTION, nullptr);
        --last_turns;
    }
    if (trouble_.empty()) {
        trouble_ = error == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(error);
    }
}

void MqttThread::rest(std::chrono::milliseconds time) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, time, [this] { return stopping_; });
}

void MqttThread::on_connected(int reason, bool resumed) {
    if (reason != 0) {
        trouble_ = mosquitto_reason_string(reason);
        return;
    }
    connected_ = true;
    resumed_ = resumed;
    tell([resumed](MqttEvents& events) { events.on_up(resumed); });
    for (const Filter& filter : settings_.filters) {
        const int qos = std::min(static_cast<int>(filter.qos), 1);
        mosquitto_subscribe_v5(
            mosquitto_, nullptr, filter.filter.c_str(), qos,
            MQTT_SUB_OPT_NO_LOCAL | MQTT_SUB_OPT_RETAIN_AS_PUBLISHED | MQTT_SUB_OPT_SEND_RETAIN_NEW,
            nullptr);
    }
}

/// MQTT 5 §3.4.2.1, §3.5.2.1 and §3.7.2.1.
void MqttThread::on_answer(int packet_id, int reason) {
    // To a repeated PUBREL: it has published the message, or forgotten it with the whole session.
    const bool is_gone = reason == MQTT_RC_PACKET_ID_NOT_FOUND;
    const bool is_busy = reason == MQTT_RC_QUOTA_EXCEEDED || (is_gone && !resumed_);
    if (reason >= first_error && !is_busy && !is_gone) {
        spdlog::warn("uplink: {} refuses a message: {}", settings_.host,
                     mosquitto_reason_string(reason));
    }
    const Answer answer = is_busy ? Answer::busy : Answer::done;
    tell([packet_id, answer](MqttEvents& told) { told.on_answer(packet_id, answer); });
}

void MqttThread::on_message(const mosquitto_message& message, std::string identity,
                            mqttsn::Qos qos) {
    const auto* octets = static_cast<const std::uint8_t*>(message.payload);
    FromRemote copy{.topic = message.topic,
                    .payload = {octets, octets + message.payloadlen},
                    .qos = qos,
                    .retain = message.retain,
                    .identity = std::move(identity),
                    .packet_id = static_cast<std::uint16_t>(message.mid)};
    const std::uint64_t token = message.qos == 0 ? 0 : ++last_token_;
    tell([copy = std::move(copy), token](MqttEvents& events) { events.on_message(copy, token); });
    if (token == 0) return;
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stopping_ || acknowledged_ >= token; });
}

}  // namespace romano::uplink
