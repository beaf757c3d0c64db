// Who publishes what to whom in a cell: the sweep file's `pattern`, spelled out as topics,
// publishers and subscribers. Pure: the swarm carries it out.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "experiments/measure/delivery_account.h"
#include "experiments/sweep/sweep_file.h"

namespace romano::experiments {

struct TrafficTopic {
    std::string name;
    Stream stream = Stream::one_to_one;
    std::vector<RobotNumber> subscribers;  // ascending
};

class Traffic {
public:
    Traffic(Pattern pattern, std::uint32_t robots, std::uint32_t group, const QosMix& qos);

    /// Robots, and behind them the server where the pattern has one.
    [[nodiscard]] std::uint32_t clients() const { return clients_; }
    [[nodiscard]] bool is_robot(RobotNumber client) const { return client < robots_; }
    [[nodiscard]] bool publishes(RobotNumber client) const;
    [[nodiscard]] const std::vector<TrafficTopic>& topics() const { return topics_; }

    /// What a client hears, and what it publishes on.
    [[nodiscard]] std::vector<const TrafficTopic*> heard_by(RobotNumber client) const;
    [[nodiscard]] std::vector<const TrafficTopic*> published_by(RobotNumber client) const;

    struct Step {
        const TrafficTopic& topic;
        std::uint8_t qos;
    };
    /// What a publisher's message `sequence` is.
    [[nodiscard]] Step step(RobotNumber publisher, std::uint32_t sequence) const;

private:
    Pattern pattern_;
    std::uint32_t robots_;
    std::uint32_t group_;
    std::uint32_t clients_;
    QosMix qos_;
    std::vector<TrafficTopic> topics_;
};

}  // namespace romano::experiments
