// The load of a cell: many MQTT-SN robots in one world, each with a port of its own and one broker
// address for life, publishing on schedule and keeping the books of what arrives.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "experiments/measure/delivery_account.h"
#include "experiments/robots/robot_client.h"
#include "experiments/robots/traffic.h"

namespace romano::experiments {

struct SwarmOptions {
    double rate_per_s = 1;  // of each publisher
    std::uint32_t payload_octets = 32;
    Duration retry{};
    std::uint64_t seed = 1;
};

class Swarm {
public:
    /// Client i lives at brokers[i % brokers.size()].
    Swarm(Surroundings& robots, Surroundings& server, std::vector<BrokerAddress> brokers,
          Traffic traffic, const SwarmOptions& options);
    ~Swarm();

    [[nodiscard]] static std::string client_id_of(RobotNumber number);

    /// Connects all clients, then subscribes; a few at a time, as a swarm is switched on.
    void join();
    /// Every client is connected, subscribed and has its topic ids.
    [[nodiscard]] bool has_joined() const { return joined_ == robots_.size(); }
    /// Why joining cannot end well: a client was refused or is lost.
    [[nodiscard]] const std::optional<std::string>& trouble() const { return trouble_; }

    /// The books' time 0.
    void start_load();
    void stop_load();
    void leave();

    /// Of the books' clock.
    [[nodiscard]] double seconds_at(Instant at) const;
    [[nodiscard]] const DeliveryAccount& account() const { return account_; }
    [[nodiscard]] std::vector<RobotNumber> clients_of(std::size_t broker) const;
    [[nodiscard]] std::size_t homes(std::size_t broker) const { return clients_of(broker).size(); }
    /// Datagrams of one type that the clients have sent so far.
    [[nodiscard]] std::uint64_t sent(mqttsn::MsgType type) const;
    /// How late a message was handed over at most, measured against its schedule: the load
    /// generator's own weakness.
    [[nodiscard]] Duration worst_lag() const { return worst_lag_; }
    /// Messages that a client's queue had no room for; they count nowhere else.
    [[nodiscard]] std::uint64_t refused() const { return refused_; }
    /// Clients that gave up on their broker (Nretry) or were disconnected by it during the load.
    [[nodiscard]] std::uint64_t lost_clients() const { return lost_clients_; }

private:
    struct Robot;

    void on_event(Robot& robot, const client::Event& event);
    void join_next();
    void advance_joining(Robot& robot);
    void schedule(Robot& robot);
    void publish_due(Robot& robot);
    void publish_one(Robot& robot);

    Surroundings& surroundings_;
    std::vector<BrokerAddress> brokers_;
    Traffic traffic_;
    SwarmOptions options_;
    std::vector<std::unique_ptr<Robot>> robots_;
    std::size_t next_to_join_ = 0;
    std::size_t joined_ = 0;
    std::optional<std::string> trouble_;

    bool loading_ = false;
    Instant started_{};
    DeliveryAccount account_;
    Duration worst_lag_{};
    std::uint64_t refused_ = 0;
    std::uint64_t lost_clients_ = 0;
};

}  // namespace romano::experiments
