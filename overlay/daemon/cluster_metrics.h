// A member's cluster as metrics.
#pragma once

#include "broker/metrics/page.h"
#include "overlay/dds/dds_transport.h"
#include "overlay/member/member_facts.h"

namespace romano::daemon {

void add_cluster(metrics::Page& page, const overlay::MemberFacts& facts);
void add_uplink(metrics::Page& page, const overlay::UplinkFacts& facts);
void add_transport(metrics::Page& page, const dds::DdsTransport& transport);

}  // namespace romano::daemon
