#include "overlay/daemon/cluster_metrics.h"

namespace romano::daemon {

void add_cluster(metrics::Page& page, const overlay::MemberFacts& facts) {
    const auto gauge = [&page](const char* name, const char* help, std::uint64_t value) {
        page.gauge(name, help, static_cast<double>(value));
    };
    gauge("romano_cluster_view_term", "Term of the view.", facts.view.number.term);
    gauge("romano_cluster_view_members", "Brokers in the view.", facts.view.members.size());
    page.counter("romano_cluster_views_total", "Views that were agreed on.", facts.views);
    page.gauge("romano_cluster_leader_info", "Who leads; always 1.", 1, {{"name", facts.leader}});
    gauge("romano_cluster_is_leader", "1 when this broker leads.", facts.leads ? 1 : 0);
    gauge("romano_cluster_condition",
          "Battery or load as this broker's rank has it, from 0 to 100 in steps.", facts.condition);
    page.counter("romano_cluster_take_overs_total",
                 "Failovers: service addresses of dead brokers that this one took over.",
                 facts.take_overs);
    page.counter("romano_cluster_replacements_total",
                 "Times that this broker was replaced while it stood still.", facts.replacements);
    page.counter("romano_cluster_leases_lost_total",
                 "Times that this broker was silent because too few peers vouched for it.",
                 facts.leases_lost);

    gauge("romano_cluster_log_position", "End of the own log.", facts.log_last);
    gauge("romano_cluster_log_unacknowledged_events",
          "Events of the own log that too few peers hold.", facts.log_last - facts.log_safe);
    gauge("romano_cluster_log_kept_events", "Events of the own log that are kept for peers.",
          facts.log_events_kept);
    for (const auto& peer : facts.peers) {
        page.gauge("romano_cluster_peer_alive", "1 when the peer is alive.", peer.alive ? 1 : 0,
                   {{"peer", peer.name}});
    }
    for (const auto& peer : facts.peers) {
        page.gauge("romano_cluster_peer_log_position", "How far the peer's log is applied here.",
                   static_cast<double>(peer.applied), {{"peer", peer.name}});
    }
    for (const auto& peer : facts.peers) {
        page.gauge("romano_cluster_peer_holds_position", "How far the peer holds the own log.",
                   static_cast<double>(peer.holds), {{"peer", peer.name}});
    }

    gauge("romano_cluster_held_datagrams", "Answers that wait for peers.", facts.held_output);
    gauge("romano_cluster_waiting_datagrams", "Datagrams that wait for their sessions.",
          facts.waiting_input);
    page.counter("romano_cluster_held_datagrams_dropped_total",
                 "Answers that were dropped because too many waited.", facts.held_output_dropped);
    page.counter("romano_cluster_waiting_datagrams_dropped_total",
                 "Datagrams that were dropped because too many waited.",
                 facts.waiting_input_dropped);
}

void add_uplink(metrics::Page& page, const overlay::UplinkFacts& facts) {
    const uplink::UplinkCounters& counters = facts.counters;
    page.gauge("romano_uplink_is_up", "1 when this broker holds the link to the MQTT broker.",
               facts.is_up ? 1 : 0);
    page.counter("romano_uplink_sent_total", "Messages to the MQTT broker, repetitions included.",
                 counters.sent);
    page.counter("romano_uplink_confirmed_total",
                 "Messages of QoS 1 and 2 that the MQTT broker answered for.", counters.confirmed);
    page.counter("romano_uplink_refused_total",
                 "Messages that the MQTT broker did not take; they are sent again.", counters.busy);
    page.counter("romano_uplink_received_total", "Messages from the MQTT broker.",
                 counters.received + facts.too_long);
    const auto drop = [&page](const char* reason, std::uint64_t value) {
        page.counter("romano_uplink_drops_total", "Messages of either way that went no further.",
                     value, {{"reason", reason}});
    };
    drop("duplicate", counters.duplicates);
    drop("own", counters.own);
    drop("unwanted", counters.unwanted);
    drop("too_long", facts.too_long);
    drop("link_down", counters.dropped);
}

void add_transport(metrics::Page& page, const dds::DdsTransport& transport) {
    const dds::TransportCounters& counters = transport.counters();
    page.counter("romano_cluster_transport_bytes_total", "Octets between brokers.",
                 counters.sent_octets, {{"direction", "sent"}});
    page.counter("romano_cluster_transport_bytes_total", "Octets between brokers.",
                 counters.received_octets, {{"direction", "received"}});
    page.counter("romano_cluster_transport_write_failures_total",
                 "Messages to brokers that DDS did not take.", counters.write_failed);
    const auto refused = [&page](const char* reason, std::uint64_t value) {
        page.counter("romano_cluster_transport_refusals_total",
                     "Messages from brokers that were dropped unread, by reason.", value,
                     {{"reason", reason}});
    };
    refused("malformed", counters.malformed);
    refused("other_protocol", counters.other_protocol);
    refused("too_many_peers", counters.too_many_peers);
    page.counter("romano_cluster_pulses_total",
                 "Times that the process said for its late core that it lives.",
                 transport.pulses_sent());
}

}  // namespace romano::daemon
