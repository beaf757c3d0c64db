// What carries the uplink's actions out: the MQTT link of romano-broker-uplink, or the bridge to
// ROS 2.
#pragma once

#include "broker/metrics/page.h"
#include "broker/uplink/uplink_core.h"
#include "overlay/member/member_facts.h"

namespace romano::daemon {

class Uplink {
public:
    virtual ~Uplink() = default;
    virtual void carry_out(const uplink::UplinkAction& action) = 0;
    /// `facts`: what the member knows of it.
    virtual void add_metrics(metrics::Page& page, const overlay::UplinkFacts& facts) const = 0;
};

}  // namespace romano::daemon
