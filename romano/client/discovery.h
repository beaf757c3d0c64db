// Which gateways there are: MQTT-SN 1.2 section 6.1, the client's side.
//
// Listens to ADVERTISE and GWINFO and searches with SEARCHGW. It chooses none: the owner looks at
// gateways() after each call. What on_tick() writes goes to the discovery group (multicast or
// broadcast) on which the owner also listens. For clients that answer other clients' searches:
// search_answer.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/fixed_vector.h"
#include "romano/base/random.h"
#include "romano/base/time.h"
#include "romano/mqttsn/body.h"
#include "romano/mqttsn/types.h"

namespace romano::client {

/// Section 7.2.
struct DiscoveryOptions {
    Duration t_searchgw{mqttsn::default_t_searchgw};
    Duration t_adv{mqttsn::default_t_adv};  // of a gateway that has not told its own
    std::uint8_t n_adv = mqttsn::default_n_adv;
    std::uint8_t radius = 0;            // everywhere
    std::uint16_t gateway_port = 1883;  // of a gwAdd without port
};

struct Gateway {
    std::uint8_t id;
    Endpoint address;
    Duration t_adv;
    Instant expires;  // N_ADV missed ADVERTISEs
};

class Discovery {
public:
    static constexpr std::size_t most_gateways = 4;  // further ones are not noted
    static constexpr std::size_t largest_datagram = 3;

    Discovery(const DiscoveryOptions& options, std::uint64_t seed)
        : options_(options), random_(seed) {}

    /// Searches until a gateway is heard: after a random wait, then ever more rarely.
    void search(Instant now);

    /// What came from `from`, on the discovery group or directly. Other messages are ignored.
    void on_datagram(Instant now, const Endpoint& from, Bytes datagram);

    /// Returns the size of a datagram for the discovery group, written to `out`; 0 when there is
    /// none. `out` holds largest_datagram.
    [[nodiscard]] std::size_t on_tick(Instant now, MutableBytes out);

    [[nodiscard]] Instant next_wakeup() const;

    /// In the order in which they were first heard.
    [[nodiscard]] std::span<const Gateway> gateways() const { return gateways_; }
    [[nodiscard]] bool is_searching() const { return search_at_ != never; }

private:
    void on_gwinfo(Instant now, const Endpoint& from, const mqttsn::Body& message);
    void note(Instant now, std::uint8_t id, const Endpoint& address, Duration t_adv);
    [[nodiscard]] Gateway* find(std::uint8_t id);
    void forget_expired(Instant now);
    void search_more_rarely(Instant now);

    DiscoveryOptions options_;
    Random random_;
    FixedVector<Gateway, most_gateways> gateways_;
    Instant search_at_ = never;
    Duration search_interval_{};
};

}  // namespace romano::client
