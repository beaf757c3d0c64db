// The bridge to ROS 2 as a broker of a cluster has it: its rules file, and its link in the uplink's
// place.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <vector>

#include "broker/daemon/settings.h"
#include "broker/metrics/page.h"
#include "overlay/daemon/uplink.h"
#include "overlay/ros2/dds/ros2_link.h"
#include "overlay/ros2/rules.h"

namespace romano::daemon {

/// Of --ros2-rules. Throws Refusal.
[[nodiscard]] std::vector<ros2::Rule> read_ros2_rules(const std::string& file);

class Ros2Bridge final : public Uplink {
public:
    /// Throws Refusal.
    Ros2Bridge(boost::asio::io_context& io, const Ros2Settings& settings,
               std::vector<ros2::Rule> rules, uplink::LinkEvents events);
    void carry_out(const uplink::UplinkAction& action) override { link_->carry_out(action); }
    void add_metrics(metrics::Page& page, const overlay::UplinkFacts& facts) const override;

private:
    std::unique_ptr<ros2::Ros2Link> link_;
};

}  // namespace romano::daemon
