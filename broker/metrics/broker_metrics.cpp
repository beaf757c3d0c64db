#include "broker/metrics/broker_metrics.h"

#include <array>
#include <string>

#include "romano/mqttsn/codec.h"

namespace romano::metrics {
namespace {

constexpr std::array<const char*, broker::drop_kinds> drop_names = {
    "wrong_direction", "unknown_sender", "stranger_rate",     "unexpected",        "invalid_topic",
    "too_large",       "queue_full",     "retries_exhausted", "refused_by_client", "encapsulation",
    "no_room",         "never_retained", "output_full"};

constexpr std::array<const char*, broker::refused_kinds> refused_names = {
    "publish", "register", "subscribe", "will", "delivery"};

constexpr std::array<const char*, mqttsn::malformed_kinds> malformed_names = {
    "empty", "length", "reserved_type", "size", "reserved_value"};

constexpr std::array<const char*, broker::session_states> state_names = {
    "active", "asleep", "awake", "disconnected", "lost"};

void add_by_type(Page& page, const char* name, const char* help,
                 const std::array<std::uint64_t, 256>& by_type) {
    const auto reserved = mqttsn::name_of(static_cast<mqttsn::MsgType>(0xFF));
    for (std::size_t type = 0; type < by_type.size(); ++type) {
        const auto known = mqttsn::name_of(static_cast<mqttsn::MsgType>(type));
        if (known == reserved) continue;
        page.counter(name, help, by_type[type], {{"type", std::string{known}}});
    }
}

}  // namespace

void add_messages(Page& page, const broker::Counters& counters) {
    add_by_type(page, "romano_messages_received_total", "MQTT-SN messages from clients, by type.",
                counters.received_by_type);
    add_by_type(page, "romano_messages_sent_total", "MQTT-SN messages to clients, by type.",
                counters.sent_by_type);
    for (std::size_t kind = 0; kind < malformed_names.size(); ++kind) {
        page.counter("romano_malformed_datagrams_total",
                     "Datagrams that are no MQTT-SN message, by what is wrong with them.",
                     counters.malformed[kind], {{"reason", malformed_names[kind]}});
    }
    for (std::size_t kind = 0; kind < drop_names.size(); ++kind) {
        page.counter("romano_drops_total",
                     "What arrived and had no effect, or waited and was given up, by reason.",
                     counters.dropped[kind], {{"reason", drop_names[kind]}});
    }
    for (std::size_t what = 0; what < refused_names.size(); ++what) {
        page.counter("romano_rights_refusals_total",
                     "What clients may not and was refused, by what it was; delivery: a message "
                     "that its subscriber may not read.",
                     counters.refused[what], {{"reason", refused_names[what]}});
    }
    page.counter("romano_publishes_received_total", "PUBLISH messages from clients.",
                 counters.publishes_received);
    page.counter("romano_publishes_sent_total", "PUBLISH messages to clients.",
                 counters.publishes_sent);
    page.counter("romano_cell_publishes_total",
                 "PUBLISH datagrams sent once for those that listen to the cell.",
                 counters.cell_publishes);
    page.counter("romano_cell_deliveries_total", "Listeners for whom those datagrams were.",
                 counters.cell_deliveries);
    page.counter("romano_cell_repairs_total",
                 "Listeners that did not answer such a datagram and were sent the message alone.",
                 counters.cell_repairs);
    page.counter("romano_retransmissions_total", "Messages sent again for lack of an answer.",
                 counters.retransmissions);
    page.counter("romano_late_answers_total",
                 "PUBACK and PUBREC that came later because a receiver's queue filled up.",
                 counters.late_answers);
    page.counter("romano_sessions_expired_total",
                 "Kept sessions that were forgotten: their clients were away for too long.",
                 counters.sessions_expired);
    page.counter("romano_sessions_forgotten_total",
                 "Kept sessions that were forgotten while their clients were away: too many of one "
                 "IP address, or to make room.",
                 counters.sessions_forgotten);
}

void add_census(Page& page, const broker::Census& census) {
    for (std::size_t state = 0; state < state_names.size(); ++state) {
        page.gauge("romano_sessions", "Sessions, by the state of their client.",
                   static_cast<double>(census.sessions[state]), {{"state", state_names[state]}});
    }
    const auto gauge = [&page](const char* name, const char* help, std::size_t value) {
        page.gauge(name, help, static_cast<double>(value));
    };
    gauge("romano_subscriptions", "Subscriptions of all sessions.", census.subscriptions);
    gauge("romano_topic_ids", "Topic ids that were given to clients.", census.topics);
    gauge("romano_queued_messages", "Messages that wait for clients.", census.queued);
    gauge("romano_longest_queue_messages", "Messages that wait for one client, at most.",
          census.longest_queue);
    gauge("romano_exchanges_in_flight", "Exchanges that wait for a client's answer.",
          census.in_flight);
    gauge("romano_unreleased_publishes", "QoS 2 publishes between PUBREC and PUBREL.",
          census.unreleased);
    gauge("romano_retained_messages", "Retained messages.", census.retained);
}

void add_datagrams(Page& page, const net::NetCounters& counters) {
    page.counter("romano_datagrams_received_total", "UDP datagrams from clients.",
                 counters.received);
    page.counter("romano_datagrams_sent_total", "UDP datagrams to clients.", counters.sent);
    const auto unsent = [&page](const char* reason, std::uint64_t value) {
        page.counter("romano_datagrams_unsent_total",
                     "Datagrams that could not be sent, by reason.", value, {{"reason", reason}});
    };
    unsent("buffer_full", counters.send_buffer_full);
    unsent("failed", counters.send_failed);
    unsent("address_gone", counters.no_such_socket);
    page.histogram("romano_datagram_handling_seconds",
                   "From a datagram's batch being read to its answers being handed to the kernel; "
                   "answers that wait for peers leave later.",
                   counters.handling);
}

void add_wakeups(Page& page, const net::CoreTimer& timer) {
    page.histogram("romano_wakeup_delay_seconds",
                   "How much later than it asked for the core was woken: by long work, or because "
                   "other programs had the processor.",
                   timer.delays());
}

void add_turns(Page& page, const net::TurnClock& turns, Instant now) {
    page.gauge(
        "romano_longest_turn_seconds",
        "The longest that the broker did one thing and nothing else, in the last half minute "
        "to minute.",
        std::chrono::duration<double>(turns.longest(now)).count());
}

}  // namespace romano::metrics
