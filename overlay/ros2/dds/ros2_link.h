// The bridge to ROS 2, opened and closed as the member says, in the uplink's place: what waits for
// it, what moves with the leader and what is known already is the uplink core's business.
//
// DDS and the bridge's core run on a thread of their own. The broker's thread hands over what goes
// out and never waits; what comes in is posted to its io_context. Both ways are bounded: beyond,
// messages are dropped and counted.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <vector>

#include "broker/uplink/uplink_core.h"
#include "overlay/ros2/dds/ros_side.h"
#include "overlay/ros2/rules.h"

namespace romano::ros2 {

struct Ros2Facts {
    bool is_open = false;
    std::size_t endpoints = 0;
    BridgeCounters counters;
    std::uint64_t overflow_out = 0;  // QoS 0: the bridge's thread did not come after
    std::uint64_t overflow_in = 0;   // the broker's thread did not come after
    std::uint64_t not_written = 0;   // DDS did not take it
};

class Ros2Thread;

class Ros2Link {
public:
    /// Joins the ROS 2 domain. Throws dds::DdsError.
    Ros2Link(boost::asio::io_context& io, const RosSettings& settings, std::vector<Rule> rules,
             uplink::LinkEvents events);
    ~Ros2Link();
    Ros2Link(const Ros2Link&) = delete;
    Ros2Link& operator=(const Ros2Link&) = delete;

    void carry_out(const uplink::UplinkAction& action);
    [[nodiscard]] Ros2Facts facts() const;

private:
    std::shared_ptr<Ros2Thread> thread_;
};

/// What the member's uplink core needs to know of the rules.
[[nodiscard]] uplink::UplinkOptions uplink_options(const std::vector<Rule>& rules);

}  // namespace romano::ros2
