#include "bench/failover/robots.h"

#include <array>
#include <chrono>
#include <utility>
#include <variant>

#include "broker/net/clock.h"

namespace romano::bench {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view topic = "bench/failover";

// Brokers come and go all the time here: the client repeats for as long as that may take.
constexpr client::Timing patient{.t_retry = 500ms, .t_wait = 1s, .n_retry = 60};

}  // namespace

Robot::Robot(boost::asio::io_context& io, std::uint32_t number,
             const experiments::BrokerAddress& broker, int qos,
             const std::shared_ptr<keys::ClientPackets>& key, OnMessage on_message)
    : number_(number),
      client_id_(key ? key->client_id() : "robot-" + std::to_string(number)),
      qos_(static_cast<mqttsn::Qos>(qos)),
      on_message_(std::move(on_message)),
      client_(
          io, broker, patient, number, [this](const client::Event& event) { on_event(event); },
          key) {
    client_.connect({.client_id = client_id_});
}

void Robot::publish() {
    if (!ready_ || !client_.core().is_idle()) return;
    std::array<std::uint8_t, experiments::Stamp::octets> payload{};
    experiments::write_stamp({number_, next_sequence_++, net::now()}, payload);
    (void)client_.publish(client::topic_name(topic), payload, {.qos = qos_});
}

void Robot::on_event(const client::Event& event) {
    if (std::holds_alternative<client::Connected>(event)) {
        (void)client_.subscribe(client::topic_name(topic), qos_);
    } else if (std::holds_alternative<client::Subscribed>(event)) {
        ready_ = true;
    } else if (const auto* received = std::get_if<client::Received>(&event)) {
        if (const auto stamp = experiments::read_stamp(received->data)) {
            on_message_(net::now(), *stamp);
        }
    } else if (!std::holds_alternative<client::Published>(event)) {
        failed_ = true;  // lost, refused, disconnected by the broker...
    }
}

}  // namespace romano::bench
