// The broker core's bounds and timers. Every table and queue has one (promise P8).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "broker/core/log_position.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"
#include "romano/mqttsn/types.h"

namespace romano::broker {

struct Limits {
    std::size_t sessions = 20'000;
    std::size_t kept_per_address = 1'000;  // kept sessions of one IP address whose clients are away
    std::size_t connecting = 1'000;        // clients in the middle of their will prompts
    std::size_t subscriptions_per_session = 10'000;
    std::size_t topics_per_session = 20'000;
    std::size_t queued_per_session = 1'000;  // QoS 1/2 waiting, and everything for a sleeper
    std::size_t retained_messages = 100'000;
    std::size_t client_id_octets = 64;  // section 5.3.1 says 23; see G20
    std::size_t payload_octets = 65'498;
    std::size_t unreleased_per_session = 64;          // QoS 2 publishes whose PUBREL is outstanding
    std::size_t stranger_datagrams_per_second = 200;  // of one address without a session that are
                                                      // heeded; the rest is dropped unanswered
    std::size_t address_stranger_datagrams_per_second = 20'000;  // the same of one IP address, of
                                                                 // whatever ports
    std::size_t stranger_answers_per_second = 2'000;  // of a kind, to all addresses without a
                                                      // session; the rest is dropped unanswered
    std::size_t pacing_ms = 1'000;     // PUBACK and PUBREC come so much later, at most, when a
                                       // receiver's queue fills up
    std::size_t session_expiry_s = 0;  // a kept session whose client was away for so long is
                                       // forgotten; 0: never
    std::size_t memory_mib = 1'024;    // of all together; the owner measures (BrokerCore::set_full)

    /// From more than that in a receiver's queue on its publishers are slowed down.
    [[nodiscard]] std::size_t half_a_queue() const { return queued_per_session / 2; }
};

struct BrokerOptions {
    LogId log;                      // the broker's own
    bool writes_log = false;        // false: a lone broker without persistence appends nothing
    Duration unix_time_at_zero{0};  // wall clock at the Instant with count 0, for HybridTime
    std::uint8_t gateway_id = 1;
    Duration advertise_every{std::chrono::minutes{15}};  // 0: never
    Duration t_retry{mqttsn::default_t_retry};
    int n_retry = mqttsn::default_n_retry;
    Duration t_wait{mqttsn::default_t_wait};  // after a client's "congestion"
    double keep_alive_tolerance = 1.5;
    Duration clean_session_kept_for{std::chrono::minutes{10}};  // after disconnection; see G11
    Duration deletions_kept_for{std::chrono::hours{1}};  // of retained messages, for late peers
    /// Where a PUBLISH goes once for those that listen there (cell.h). Family none: nowhere.
    Endpoint cell_group;
    std::map<mqttsn::TopicId, std::string> predefined_topics;
    std::vector<std::string> observed_topics;  // what clients publish there is told as Observed
    /// What must not come to a later subscriber: delivered, but never kept as retained. Null: all
    /// is.
    bool (*never_retained)(std::string_view topic, Bytes payload) = nullptr;
    /// Under '$', where else brokers alone publish, and open to clients whom permissions let; or
    /// none.
    std::string open_topic;
    std::string read_by_owner;  // client id of the session whose queue the owner reads; or none
    Limits limits;
};

}  // namespace romano::broker
