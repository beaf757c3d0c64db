#include "overlay/sim/drawn_rights.h"

#include <stdexcept>
#include <utility>

#include "broker/rights/rules.h"
#include "overlay/sim/seed.h"

namespace romano::sim {
namespace {

std::string rule(std::string_view access, std::string_view topic) {
    return "topic " + std::string{access} + ' ' + std::string{topic} + '\n';
}

}  // namespace

DrawnRights::DrawnRights(std::uint64_t seed, std::span<const std::string> robots,
                         std::span<const std::string_view> topics) {
    Random random(seed_of(seed, "rights"));
    std::vector<rights::KeyOwner> owners;
    for (const std::string& robot : robots) {
        owners.push_back({robot, rights::Role::robot});
        const RobotRights first = draw(random, robot, topics);
        const bool keeps_them = random.below(2) == 0;
        rules_[1].table.emplace(robot, keeps_them ? first : draw(random, robot, topics));
        rules_[0].table.emplace(robot, first);
    }
    for (Rules& rules : rules_) {
        std::string text;
        for (const auto& [robot, its] : rules.table) text += its.rules;
        auto parsed = rights::parse(text);
        if (!parsed) throw std::logic_error("line " + std::to_string(parsed.error().line));
        rules.digest = rights::digest_of(*parsed);
        rules.rights = std::make_unique<rights::Rights>(std::move(*parsed), owners);
    }
}

/// A file allows single topics, or everything but some.
DrawnRights::RobotRights DrawnRights::draw(Random& random, const std::string& robot,
                                           std::span<const std::string_view> topics) {
    RobotRights drawn{.rules = "user " + robot + '\n', .on = {}};
    const bool is_open = random.below(3) == 0;
    drawn.rules += rule("readwrite", is_open ? "#" : "will/+");
    for (const std::string_view topic : topics) {
        Right right{.reads = random.below(4) != 0, .publishes = random.below(4) != 0};
        if (is_open) right.publishes = right.reads;
        drawn.on.emplace(topic, right);
        if (is_open) {
            if (!right.reads) drawn.rules += rule("deny", topic);
        } else if (right.reads || right.publishes) {
            drawn.rules += rule(!right.publishes ? "read"
                                : right.reads    ? "readwrite"
                                                 : "write",
                                topic);
        }
    }
    return drawn;
}

DrawnRights::InForce DrawnRights::in_force() const {
    const Rules& rules = rules_[changed_ ? 1 : 0];
    return {rules.rights.get(), rules.digest};
}

DrawnRights::Right DrawnRights::find(const Table& table, const std::string& robot,
                                     const std::string& topic) {
    const auto its = table.find(robot);
    if (its == table.end()) return {};
    const auto right = its->second.on.find(topic);
    return right == its->second.on.end() ? Right{} : right->second;
}

bool DrawnRights::surely(const std::string& robot, const Sent& message, bool Right::*which) const {
    const bool at_first = find(rules_[0].table, robot, message.topic).*which;
    if (!changed_) return at_first;
    const bool now = find(rules_[1].table, robot, message.topic).*which;
    return now && (at_first || (settled_ && message.at > *settled_));
}

bool DrawnRights::possibly(const std::string& robot, const Sent& message,
                           bool Right::*which) const {
    const bool at_first = find(rules_[0].table, robot, message.topic).*which;
    if (!changed_) return at_first;
    const bool now = find(rules_[1].table, robot, message.topic).*which;
    return now || (at_first && !(settled_ && message.at > *settled_));
}

bool DrawnRights::surely_reads(const std::string& robot, const Sent& message) const {
    return surely(robot, message, &Right::reads);
}
bool DrawnRights::surely_publishes(const Sent& message) const {
    return surely(message.publisher, message, &Right::publishes);
}
bool DrawnRights::possibly_reads(const std::string& robot, const Sent& message) const {
    return possibly(robot, message, &Right::reads);
}
bool DrawnRights::possibly_publishes(const Sent& message) const {
    return possibly(message.publisher, message, &Right::publishes);
}

}  // namespace romano::sim
