// MQTT over TCP by libmosquitto, with TCP_NODELAY. Reliable is QoS 1.

#include <mosquitto.h>
#include <poll.h>

#include <stdexcept>
#include <utility>

#include "bench/ros/node/data_path.h"
#include "broker/net/clock.h"

namespace romano::bench::ros {
namespace {

using namespace std::chrono_literals;

constexpr int keep_alive_s = 10;
constexpr auto again_after = 1s;  // the library's own reconnect delay

class MosquittoPath : public DataPath {
public:
    MosquittoPath(const NodePlan& plan, OnMessage on_message)
        : plan_(plan), on_message_(std::move(on_message)) {
        ::mosquitto_lib_init();
        handle_ = ::mosquitto_new(plan.name.c_str(), true, this);
        if (handle_ == nullptr) throw std::runtime_error("no memory for a client");
        ::mosquitto_int_option(handle_, MOSQ_OPT_TCP_NODELAY, 1);
        ::mosquitto_connect_callback_set(handle_, [](mosquitto*, void* self, int code) {
            if (code == 0) static_cast<MosquittoPath*>(self)->subscribe();
        });
        ::mosquitto_message_callback_set(
            handle_, [](mosquitto*, void* self, const mosquitto_message* message) {
                static_cast<MosquittoPath*>(self)->on_message_(
                    {static_cast<const std::uint8_t*>(message->payload),
                     static_cast<std::size_t>(message->payloadlen)});
            });
        try_to_connect();
    }
    ~MosquittoPath() override {
        ::mosquitto_destroy(handle_);
        ::mosquitto_lib_cleanup();
    }
    void publish(std::size_t topic, Bytes payload) override {
        ::mosquitto_publish(handle_, nullptr, plan_.publishes[topic].c_str(),
                            static_cast<int>(payload.size()), payload.data(), qos(), false);
    }
    void turn(Instant until) override {
        const int socket = ::mosquitto_socket(handle_);
        pollfd wanted{.fd = socket, .events = POLLIN, .revents = 0};
        if (socket >= 0 && ::mosquitto_want_write(handle_)) wanted.events |= POLLOUT;
        const auto left = std::max(Duration{0}, until - net::now());
        const timespec timeout{.tv_sec = left / 1s, .tv_nsec = (left % 1s).count()};
        ::ppoll(&wanted, 1, &timeout, nullptr);
        if (socket < 0) {
            if (net::now() >= again_at_) try_to_connect();
            return;
        }
        bool is_up = true;
        if ((wanted.revents & (POLLIN | POLLHUP | POLLERR)) != 0) {
            is_up = ::mosquitto_loop_read(handle_, 1) == MOSQ_ERR_SUCCESS;
        }
        while (is_up && ::mosquitto_want_write(handle_)) {
            is_up = ::mosquitto_loop_write(handle_, 1) == MOSQ_ERR_SUCCESS;
            if ((wanted.revents & POLLOUT) == 0) break;
        }
        if (is_up) is_up = ::mosquitto_loop_misc(handle_) == MOSQ_ERR_SUCCESS;
        if (!is_up) again_at_ = net::now() + again_after;
    }

private:
    [[nodiscard]] int qos() const { return plan_.reliable ? 1 : 0; }
    void try_to_connect() {
        again_at_ = net::now() + again_after;
        if (is_known_) {
            ::mosquitto_reconnect(handle_);
        } else {
            is_known_ = ::mosquitto_connect(handle_, plan_.infrastructure.c_str(), 1883,
                                            keep_alive_s) != MOSQ_ERR_INVAL;
        }
    }
    void subscribe() {
        for (const std::string& topic : plan_.subscribes) {
            ::mosquitto_subscribe(handle_, nullptr, topic.c_str(), qos());
        }
    }

    const NodePlan& plan_;
    OnMessage on_message_;
    mosquitto* handle_ = nullptr;
    bool is_known_ = false;  // to the library: the broker's address
    Instant again_at_{};
};

}  // namespace

std::unique_ptr<DataPath> make_data_path(const NodePlan& plan, DataPath::OnMessage on_message) {
    return std::make_unique<MosquittoPath>(plan, std::move(on_message));
}

}  // namespace romano::bench::ros
