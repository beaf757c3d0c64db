// MQTT-SN by this project's client core on a UDP socket, with the timing of romano-robot. Reliable
// is QoS 1.

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <utility>
#include <variant>

#include "bench/ros/node/data_path.h"
#include "broker/net/clock.h"
#include "experiments/robots/socket_client.h"

namespace romano::bench::ros {
namespace {

using namespace std::chrono_literals;

class MqttsnPath : public DataPath {
public:
    MqttsnPath(const NodePlan& plan, OnMessage on_message)
        : plan_(plan),
          on_message_(std::move(on_message)),
          again_(io_),
          client_(io_, experiments::resolve_broker(io_, plan.infrastructure, 1883), {.t_retry = 1s},
                  std::hash<std::string>{}(plan.name), [this](const client::Event& event) {
                      std::visit([this](const auto& each) { on(each); }, event);
                  }) {
        connect();
    }
    void publish(std::size_t topic, Bytes payload) override {
        (void)client_.publish(client::topic_name(plan_.publishes[topic]), payload, {.qos = qos()});
    }
    void turn(Instant until) override {
        io_.restart();
        if (io_.run_one_until(net::to_steady_clock(until)) > 0) io_.poll();
    }

private:
    [[nodiscard]] mqttsn::Qos qos() const {
        return plan_.reliable ? mqttsn::Qos::at_least_once : mqttsn::Qos::at_most_once;
    }
    void connect() { client_.connect({.client_id = plan_.name, .keep_alive = 10s}); }
    void connect_again() {
        again_.expires_after(200ms);
        again_.async_wait([this](auto failed) {
            if (!failed) connect();
        });
    }
    void on(const client::Connected&) {
        for (const std::string& topic : plan_.subscribes) {
            (void)client_.subscribe(client::topic_name(topic), qos());
        }
    }
    void on(const client::Received& message) { on_message_(message.data); }
    void on(const client::Lost&) { connect_again(); }
    void on(const client::Refused&) { connect_again(); }
    void on(const client::Disconnected&) { connect_again(); }
    template <typename Other>
    void on(const Other&) {}

    const NodePlan& plan_;
    OnMessage on_message_;
    boost::asio::io_context io_{1};
    boost::asio::steady_timer again_;
    experiments::SocketClient client_;
};

}  // namespace

std::unique_ptr<DataPath> make_data_path(const NodePlan& plan, DataPath::OnMessage on_message) {
    return std::make_unique<MqttsnPath>(plan, std::move(on_message));
}

}  // namespace romano::bench::ros
