// The bridge without I/O: which ROS 2 endpoints there are, what goes to them, what comes from them.
//
// A robot is whatever stands for the + of a rule. It is known from the first message of a rule's
// type, or the first ROS 2 writer that a rule wants, and then has all endpoints of the rules with
// +, under a node of its own. The endpoints are bounded; what would need more is dropped and
// counted.
//
// A movement becomes a velocity that is repeated until its end, because drivers of ROS 2 stop by
// themselves when they hear nothing for a while; at its end the velocity is zero. A bridge that
// takes over from a dead one stops what that one may have set in motion.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "overlay/ros2/conversion.h"
#include "overlay/ros2/ros_messages.h"
#include "overlay/ros2/rules.h"
#include "romano/base/time.h"
#include "romano/mqttsn/types.h"

namespace romano::ros2 {

/// A ROS 2 publisher or subscription that is wanted from now on.
struct MakeEndpoint {
    std::string topic;
    RosType type{};
    bool writes = false;
    bool reliable = true;   // of QoS 1 or 2; its publishers are reliable in any case, which suits
                            // every subscription
    bool retained = false;  // transient-local
    std::string node;
};
/// To ROS 2, by a writer that MakeEndpoint wanted before.
struct ToRos {
    std::string topic;
    RosMessage message;
};
/// To be published here.
struct ToRomano {
    std::string topic;
    Payload payload;
    mqttsn::Qos qos{};
    bool retain = false;
};
using BridgeAction = std::variant<MakeEndpoint, ToRos, ToRomano>;

/// What was published here, for ROS 2.
struct FromRomano {
    std::string topic;
    Payload payload;
    std::uint64_t unix_ms = 0;  // when it was published
};

struct BridgeCounters {
    std::uint64_t to_ros = 0;    // ROS 2 messages
    std::uint64_t from_ros = 0;  // ROS 2 messages
    std::uint64_t unfit = 0;     // of either way: what no rule's type can say
    std::uint64_t bad_name = 0;  // what would have no valid name on the other side
    std::uint64_t too_many = 0;  // beyond the bound of endpoints
};

class BridgeCore {
public:
    static constexpr std::size_t most_endpoints = 10'000;
    static constexpr Duration repeat_every{std::chrono::milliseconds{100}};

    explicit BridgeCore(std::vector<Rule> rules) : rules_(std::move(rules)) {}

    /// It holds the bridge from now on: the endpoints of rules without a wildcard.
    void open(std::vector<BridgeAction>& out);
    /// What moves is stopped; nothing of before counts any more.
    void close(std::vector<BridgeAction>& out);

    void on_romano(Instant now, const FromRomano& message, std::vector<BridgeAction>& out);
    void on_ros(const std::string& topic, const RosMessage& message,
                std::vector<BridgeAction>& out);
    /// ROS 2 has a writer there; the rule that wants it, if one does.
    const Rule* on_ros_writer(const std::string& topic, std::vector<BridgeAction>& out);
    /// A bridge that was there before had a writer there.
    void take_over(const std::string& topic, std::vector<BridgeAction>& out);

    void on_tick(Instant now, std::vector<BridgeAction>& out);
    [[nodiscard]] Instant next_wakeup() const;

    [[nodiscard]] const BridgeCounters& counters() const { return counters_; }
    [[nodiscard]] std::size_t endpoints() const { return writers_.size() + readers_.size(); }

private:
    struct Moving {
        Twist velocity;
        Instant ends;
        Instant repeat;
    };

    /// False when there is none and can be none.
    bool has_endpoint(const Rule& rule, const std::string& topic, const std::string& part,
                      bool writes, std::vector<BridgeAction>& out);
    void know_robot(const std::string& part, std::vector<BridgeAction>& out);
    void publish(const std::string& topic, RosMessage message, std::vector<BridgeAction>& out);
    void move(Instant now, const std::string& topic, const Motion& motion,
              std::vector<BridgeAction>& out);
    void stop(const std::string& topic, std::vector<BridgeAction>& out);
    void schedule(const std::string& topic, const Moving& moving);
    /// A speed goes out with the next location.
    struct Speed {
        Twist twist;
    };
    using Content = std::variant<Motion, Speed, RosMessage>;
    /// What a rule makes of it for that topic; nothing when it is of no such type.
    [[nodiscard]] std::optional<Content> content_of(const Rule& rule, const std::string& topic,
                                                    const std::string& part,
                                                    const FromRomano& message) const;

    std::vector<Rule> rules_;
    std::map<std::string, RosType> writers_;  // by ROS 2 topic
    std::map<std::string, RosType> readers_;
    std::set<std::string> robots_;          // what stands for +
    std::map<std::string, Twist> speeds_;   // by Odometry's topic, of which there is a writer
    std::map<std::string, Moving> moving_;  // by Twist's topic, likewise
    std::set<std::pair<Instant, std::string>> due_;  // of moving_: when to write next
    BridgeCounters counters_;
};

}  // namespace romano::ros2
