#include "overlay/ros2/bridge_core.h"

#include <algorithm>

#include "romano/message/codec.h"
#include "romano/mqttsn/topic.h"

namespace romano::ros2 {

using Actions = std::vector<BridgeAction>;

void BridgeCore::open(Actions& out) {
    close(out);
    for (const Rule& rule : rules_) {
        if (has_wildcard(rule.ros)) continue;
        if (rule.out) has_endpoint(rule, rule.ros, {}, true, out);
        if (rule.in) has_endpoint(rule, rule.ros, {}, false, out);
    }
}

void BridgeCore::close(Actions& out) {
    while (!moving_.empty()) stop(std::string{moving_.begin()->first}, out);
    writers_.clear();
    readers_.clear();
    robots_.clear();
    speeds_.clear();
}

// --- endpoints

bool BridgeCore::has_endpoint(const Rule& rule, const std::string& topic, const std::string& part,
                              bool writes, Actions& out) {
    auto& made = writes ? writers_ : readers_;
    if (const auto found = made.find(topic); found != made.end()) return found->second == rule.type;
    if (endpoints() >= most_endpoints) return false;
    made.emplace(topic, rule.type);
    const std::string node = filled(rule.node, part);
    out.emplace_back(MakeEndpoint{.topic = topic,
                                  .type = rule.type,
                                  .writes = writes,
                                  .reliable = rule.qos != mqttsn::Qos::at_most_once,
                                  .retained = rule.retained,
                                  .node = is_ros_name(node) ? node : bridge_node});
    return true;
}

void BridgeCore::know_robot(const std::string& part, Actions& out) {
    if (endpoints() >= most_endpoints || !robots_.insert(part).second) return;
    for (const Rule& rule : rules_) {
        if (rule.ros.find('+') == std::string::npos) continue;
        const std::string topic = filled(rule.ros, part);
        if (!is_ros_topic(topic) || !mqttsn::is_valid_topic_name(filled(rule.romano, part))) {
            continue;
        }
        if (rule.out) has_endpoint(rule, topic, part, true, out);
        if (rule.in) has_endpoint(rule, topic, part, false, out);
    }
}

const Rule* BridgeCore::on_ros_writer(const std::string& topic, Actions& out) {
    for (const Rule& rule : rules_) {
        const auto part = rule.in ? wild_part(rule.ros, topic) : std::nullopt;
        if (!part) continue;
        if (rule.ros.find('+') != std::string::npos) know_robot(*part, out);
        if (!has_endpoint(rule, topic, *part, false, out)) ++counters_.too_many;
        return &rule;
    }
    return nullptr;
}

void BridgeCore::take_over(const std::string& topic, Actions& out) {
    for (const Rule& rule : rules_) {
        const auto part = rule.out ? wild_part(rule.ros, topic) : std::nullopt;
        if (!part) continue;
        if (rule.ros.find('+') != std::string::npos) know_robot(*part, out);
        if (rule.type == RosType::twist && has_endpoint(rule, topic, *part, true, out)) {
            stop(topic, out);
        }
        return;
    }
}

// --- to ROS 2

void BridgeCore::on_romano(Instant now, const FromRomano& message, Actions& out) {
    std::uint64_t* why_not = &counters_.unfit;
    bool is_carried = false;
    for (const Rule& rule : rules_) {
        const auto part = rule.out ? wild_part(rule.romano, message.topic) : std::nullopt;
        if (!part) continue;
        const std::string topic = filled(rule.ros, *part);
        auto content = content_of(rule, topic, *part, message);
        if (!content) continue;
        if (!is_ros_topic(topic)) {
            why_not = &counters_.bad_name;
            continue;
        }
        if (rule.ros.find('+') != std::string::npos) know_robot(*part, out);
        if (!has_endpoint(rule, topic, *part, true, out)) {
            why_not = &counters_.too_many;
            continue;
        }
        is_carried = true;
        if (const auto* motion = std::get_if<Motion>(&*content)) {
            move(now, topic, *motion, out);
        } else if (const auto* speed = std::get_if<Speed>(&*content)) {
            speeds_.insert_or_assign(topic, speed->twist);
        } else {
            publish(topic, std::move(std::get<RosMessage>(*content)), out);
        }
    }
    if (!is_carried) ++*why_not;
}

std::optional<BridgeCore::Content> BridgeCore::content_of(const Rule& rule,
                                                          const std::string& topic,
                                                          const std::string& part,
                                                          const FromRomano& message) const {
    if (rule.type == RosType::twist || rule.type == RosType::odometry) {
        const auto decoded = message::decode(message.payload);
        if (!decoded) return std::nullopt;
        if (rule.type == RosType::twist) {
            const auto* movement = std::get_if<message::MovementControl>(&decoded.value());
            if (movement == nullptr) return std::nullopt;
            const auto motion = motion_of(*movement, rule);
            return motion ? std::optional<Content>{*motion} : std::nullopt;
        }
        const auto* sensor = std::get_if<message::SensorData>(&decoded.value());
        if (const auto speed = sensor == nullptr ? std::nullopt : twist_of(*sensor)) {
            return Speed{*speed};
        }
    }
    const auto speed = speeds_.find(topic);
    auto converted = to_ros(message.payload, rule, part, message.unix_ms,
                            speed == speeds_.end() ? Twist{} : speed->second);
    return converted ? std::optional<Content>{std::move(*converted)} : std::nullopt;
}

void BridgeCore::publish(const std::string& topic, RosMessage message, Actions& out) {
    ++counters_.to_ros;
    out.emplace_back(ToRos{topic, std::move(message)});
}

void BridgeCore::move(Instant now, const std::string& topic, const Motion& motion, Actions& out) {
    if (motion.time <= Duration::zero()) return stop(topic, out);
    publish(topic, motion.velocity, out);
    const Instant ends = now + motion.time;
    schedule(topic, {motion.velocity, ends, std::min(ends, now + repeat_every)});
}

void BridgeCore::stop(const std::string& topic, Actions& out) {
    if (const auto found = moving_.find(topic); found != moving_.end()) {
        due_.erase({found->second.repeat, topic});
        moving_.erase(found);
    }
    publish(topic, Twist{}, out);
}

void BridgeCore::schedule(const std::string& topic, const Moving& moving) {
    if (const auto found = moving_.find(topic); found != moving_.end()) {
        due_.erase({found->second.repeat, topic});
    }
    moving_.insert_or_assign(topic, moving);
    due_.emplace(moving.repeat, topic);
}

void BridgeCore::on_tick(Instant now, Actions& out) {
    while (!due_.empty() && due_.begin()->first <= now) {
        const std::string topic = due_.begin()->second;
        const Moving moving = moving_.at(topic);
        if (moving.ends <= now) {
            stop(topic, out);
            continue;
        }
        publish(topic, moving.velocity, out);
        schedule(topic, {moving.velocity, moving.ends, std::min(moving.ends, now + repeat_every)});
    }
}

Instant BridgeCore::next_wakeup() const {
    return due_.empty() ? never : due_.begin()->first;
}

// --- from ROS 2

void BridgeCore::on_ros(const std::string& topic, const RosMessage& message, Actions& out) {
    ++counters_.from_ros;
    for (const Rule& rule : rules_) {
        const auto part = rule.in ? wild_part(rule.ros, topic) : std::nullopt;
        if (!part || static_cast<std::size_t>(rule.type) != message.index()) continue;
        const std::string name = filled(rule.romano, *part);
        if (!mqttsn::is_valid_topic_name(name)) {
            ++counters_.bad_name;
            return;
        }
        auto payloads = to_romano(message, rule);
        if (payloads.empty()) ++counters_.unfit;
        for (Payload& payload : payloads) {
            out.emplace_back(ToRomano{name, std::move(payload), rule.qos, rule.retained});
        }
        return;
    }
    ++counters_.unfit;
}

}  // namespace romano::ros2
