#include "experiments/robots/traffic.h"

#include <algorithm>
#include <cassert>

namespace romano::experiments {

Traffic::Traffic(Pattern pattern, std::uint32_t robots, std::uint32_t group, const QosMix& qos)
    : pattern_(pattern),
      robots_(robots),
      group_(group),
      clients_(pattern == Pattern::swarm ? robots : robots + 1),
      qos_(qos) {
    if (pattern_ == Pattern::common) {
        TrafficTopic common{.name = "common", .stream = Stream::group, .subscribers = {}};
        for (RobotNumber robot = 0; robot < robots_; ++robot) common.subscribers.push_back(robot);
        topics_.push_back(std::move(common));
        return;
    }
    // First one topic for each robot. In a swarm, robot r publishes on it and the next robot
    // listens: robots are dealt to the brokers in turn, so the message crosses to another broker.
    for (RobotNumber robot = 0; robot < robots_; ++robot) {
        const RobotNumber listener = pattern_ == Pattern::swarm ? (robot + 1) % robots_ : robot;
        topics_.push_back({.name = "robots/" + std::to_string(robot),
                           .stream = Stream::one_to_one,
                           .subscribers = {listener}});
    }
    if (pattern_ == Pattern::commands) return;
    for (RobotNumber first = 0; first < robots_; first += group_) {
        TrafficTopic topic{.name = "groups/" + std::to_string(first / group_),
                           .stream = Stream::group,
                           .subscribers = {}};
        for (RobotNumber robot = first; robot < std::min(first + group_, robots_); ++robot) {
            topic.subscribers.push_back(robot);
        }
        topics_.push_back(std::move(topic));
    }
}

bool Traffic::publishes(RobotNumber client) const {
    return pattern_ == Pattern::swarm || client == robots_;
}

std::vector<const TrafficTopic*> Traffic::heard_by(RobotNumber client) const {
    std::vector<const TrafficTopic*> heard;
    for (const TrafficTopic& topic : topics_) {
        if (std::ranges::binary_search(topic.subscribers, client)) heard.push_back(&topic);
    }
    return heard;
}

std::vector<const TrafficTopic*> Traffic::published_by(RobotNumber client) const {
    std::vector<const TrafficTopic*> used;
    if (!publishes(client)) return used;
    if (pattern_ == Pattern::swarm) {
        return {&topics_[client], &topics_[robots_ + client / group_]};
    }
    for (const TrafficTopic& topic : topics_) used.push_back(&topic);
    return used;
}

Traffic::Step Traffic::step(RobotNumber publisher, std::uint32_t sequence) const {
    assert(publishes(publisher));
    // Every publisher begins at another place, or all would send the same level at the same time.
    const std::uint32_t turn = sequence + publisher;
    const std::uint8_t qos = qos_.level(turn);
    switch (pattern_) {
        case Pattern::common:
            return {topics_.front(), qos};
        case Pattern::commands:
            return {topics_[sequence % robots_], qos};
        case Pattern::swarm:
            break;
    }
    // The stream changes after a whole round of levels, so that each stream has all levels.
    const bool to_group = (turn / qos_.size()) % 2 == 1;
    return {topics_[to_group ? robots_ + publisher / group_ : publisher], qos};
}

}  // namespace romano::experiments
