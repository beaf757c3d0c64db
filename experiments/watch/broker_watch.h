// Looks at the cluster with one broker's eyes: a plain MQTT-SN client that subscribes to
// $SYS/brokers/+ there and keeps the latest word on each broker.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "experiments/robots/robot_client.h"
#include "experiments/watch/broker_status.h"

namespace romano::experiments {

class BrokerWatch {
public:
    struct Seen {
        BrokerStatus status;
        std::string text;  // as it came
    };

    /// `on_change` is called after each word on a broker; may be empty. At QoS 1 no word is lost,
    /// and brokers replicate the watch's session for it.
    BrokerWatch(Surroundings& surroundings, const BrokerAddress& broker,
                const std::string& client_id, const client::Timing& timing,
                std::function<void()> on_change, mqttsn::Qos qos = mqttsn::Qos::at_least_once);

    [[nodiscard]] const std::map<std::string, Seen>& brokers() const { return brokers_; }
    /// The brokers said to be alive.
    [[nodiscard]] std::size_t alive() const;
    /// The living broker that is said to lead; empty when there is none.
    [[nodiscard]] std::optional<std::string> leader() const;

    /// The members of the view that `broker` says it is in; 0 while it has said nothing.
    [[nodiscard]] std::size_t members_in_view_of(const std::string& broker) const;

    [[nodiscard]] bool is_subscribed() const { return subscribed_; }
    /// No answer after all repetitions, or a refusal: it watches no more.
    [[nodiscard]] bool has_failed() const { return failed_; }
    /// The broker answered, with a refusal.
    [[nodiscard]] std::optional<mqttsn::ReturnCode> denial() const { return denial_; }
    [[nodiscard]] const RobotClient& client() const { return client_; }
    void leave();

private:
    void connect();
    void on_event(const client::Event& event);

    std::string client_id_;
    std::function<void()> on_change_;
    mqttsn::Qos qos_;
    std::map<std::string, Seen> brokers_;
    bool subscribed_ = false;
    bool failed_ = false;
    std::optional<mqttsn::ReturnCode> denial_;
    bool leaving_ = false;
    RobotClient client_;
};

}  // namespace romano::experiments
