// What a member knows about itself and its peers, for people and for metrics.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "broker/uplink/uplink_core.h"
#include "overlay/cluster/messages.h"

namespace romano::overlay {

struct PeerFacts {
    std::string name;
    bool alive = false;
    broker::Seq applied = 0;  // how far its log is applied here
    broker::Seq holds = 0;    // how far it holds ours
};

struct UplinkFacts {
    bool is_up = false;  // this broker holds the link, and the MQTT broker answers
    uplink::UplinkCounters counters;
    std::uint64_t too_long = 0;  // messages of the MQTT broker that no MQTT-SN client can be sent
};

struct MemberFacts {
    cluster::View view;
    std::string leader;  // empty: nobody, or nobody known
    bool leads = false;
    std::uint32_t condition = 0;  // battery or load, as the own rank has it
    broker::Seq log_last = 0;
    broker::Seq log_safe = 0;         // held by as many peers as must
    std::size_t log_events_kept = 0;  // for peers that lag
    std::uint64_t views = 0;          // agreed on since the start
    std::uint64_t take_overs = 0;     // service addresses of dead brokers that we inherited
    std::uint64_t replacements = 0;   // times that we were replaced while we stood still
    std::uint64_t leases_lost = 0;    // and clients waited for it
    std::size_t held_output = 0;      // datagrams that wait for peers
    std::uint64_t held_output_dropped = 0;
    std::size_t waiting_input = 0;  // datagrams that wait for their sessions
    std::uint64_t waiting_input_dropped = 0;
    std::vector<PeerFacts> peers;  // by name
    std::optional<UplinkFacts> uplink;
};

}  // namespace romano::overlay
