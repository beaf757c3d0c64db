// A broker core behind its DTLS address, as a shell composes them, for clients without sockets.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "broker/core/broker_core.h"
#include "broker/dtls/openssl/listener.h"
#include "tests/broker/ciphered_clients.h"

namespace romano::dtls::broker_with_dtls {

using broker::test::connect_as;
using broker::test::endpoint;
using broker::test::Octets;
using broker::test::octets_of;
using broker::test::ping;
using broker::test::Sent;

inline Endpoint dtls_service() {
    Endpoint out = endpoint(1, 8883);
    out.packets = Endpoint::Packets::dtls;
    return out;
}

inline const Endpoint service = dtls_service();
inline const Endpoint place = endpoint(10, 5000);
inline const Endpoint other_place = endpoint(11, 5000);
inline const protection::RobotKey key_a{{0xA}};
inline const protection::RobotKey key_b{{0xB}};

struct Broker {
    explicit Broker(std::uint32_t its_place)
        : place_of(its_place), listener({place_of, reserve}, {0x5E}), core({}, 1) {
        const std::vector<broker::ProtectedClient> all{{"a", key_a}, {"b", key_b}};
        listener.set_clients(all);
    }
    std::vector<Sent> take(const Endpoint& from, Bytes datagram) {
        broker::Actions actions;
        listener.take(now, {service, from}, datagram, actions, [&](const Message& message) {
            delivered.emplace_back(message.octets.begin(), message.octets.end());
            core.on_datagram(now, message.path.via, message.path.from, message.octets, actions);
        });
        return drain(actions);
    }
    std::vector<Sent> wait(std::chrono::seconds time) {
        now += Duration{time};
        broker::Actions actions;
        listener.on_time(now, actions);
        return drain(actions);
    }
    std::vector<Sent> drain(broker::Actions& actions) {
        if (const auto bound = reserve.to_store()) reserve.on_stored(*bound);
        listener.seal(actions);
        return broker::test::sent_to_clients(actions);
    }
    std::uint64_t refused(Refusal why) const {
        return listener.clients().counters().refused.of(why);
    }

    // --- several brokers
    /// What the other has to tell.
    void hear(Broker& other) { listener.clients().on_told(other.listener.clients().to_tell()); }
    /// Goes on in the other's place.
    void adopt(Broker& other, const std::string& client) {
        auto image = other.core.image(client);
        ASSERT_TRUE(image);
        broker::Actions actions;
        ASSERT_TRUE(core.adopt(now, std::move(*image), {}, actions));
        (void)drain(actions);
    }

    std::uint32_t place_of;
    protection::Reserve reserve{0};
    Instant now{};
    Listener listener;
    broker::BrokerCore core;
    std::vector<Octets> delivered;
};

}  // namespace romano::dtls::broker_with_dtls
