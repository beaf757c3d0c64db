// Log events, and who writes them, for tests, by the shortest words.
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "broker/core/broker_core.h"
#include "broker/core/log_event.h"
#include "overlay/cluster/times.h"
#include "romano/base/endpoint.h"

namespace romano::test {

/// Those of ClusterOptions{}.
inline constexpr cluster::Times times{.beacon_every = std::chrono::milliseconds{10},
                                      .detection = std::chrono::milliseconds{100},
                                      .found_again_within = std::chrono::milliseconds{500},
                                      .people_told_every = std::chrono::seconds{1}};

inline broker::LogId log_of(std::string_view name, std::uint64_t incarnation = 1) {
    return {broker::broker_id_of(name), incarnation};
}

inline broker::BrokerOptions writer_of(const broker::LogId& log) {
    broker::BrokerOptions options;
    options.log = log;
    options.writes_log = true;
    return options;
}

inline Endpoint address(int host) {
    Endpoint endpoint{};
    endpoint.address = {10, 0, 0, static_cast<std::uint8_t>(host)};
    endpoint.port = 1883;
    endpoint.family = Endpoint::Family::ipv4;
    return endpoint;
}

inline broker::LogEvent session(std::string client, const Endpoint& via = {}) {
    broker::SessionPut event{};
    event.image.header.client_id = std::move(client);
    event.image.header.via = via;
    return event;
}

inline broker::LogEvent erased(std::string client) {
    return broker::SessionErased{std::move(client)};
}

/// That session, as it is, to the broker with that log.
inline broker::LogEvent moved(const broker::LogEvent& session, const broker::LogId& to) {
    return broker::SessionMoved{std::get<broker::SessionPut>(session).image.header, to};
}

inline broker::LogEvent subscribed(std::string client, std::string filter) {
    broker::Subscribed event{};
    event.client_id = std::move(client);
    event.subscription.filter = std::move(filter);
    return event;
}

inline broker::LogEvent unsubscribed(std::string client, std::string filter) {
    return broker::Unsubscribed{std::move(client), std::move(filter)};
}

inline broker::LogEvent published(const broker::LogId& log, broker::Seq seq,
                                  const std::string& topic = "pose") {
    broker::Message message{};
    message.topic = topic;
    message.qos = mqttsn::Qos::at_least_once;
    message.position = {log, seq};
    broker::Published event{};
    event.message = broker::MessagePtr{std::move(message)};
    return event;
}

}  // namespace romano::test
