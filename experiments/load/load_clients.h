// The clients of a load, as its run sees them: whoever can join, publish and receive. MQTT-SN
// clients are one kind (mqttsn_clients.h); a bench may bring others, and measure them alike.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "romano/base/bytes.h"
#include "romano/base/time.h"

namespace romano::experiments {

class LoadClients {
public:
    using Number = std::uint32_t;
    /// Names one publish of a client until it is acknowledged.
    using PublishId = std::uint32_t;

    class Listener {
    public:
        virtual ~Listener() = default;
        /// Connected, subscribed, and ready to publish.
        virtual void on_joined(Number client) = 0;
        /// It was read at `now`. `again`: the broker says that it sent this before (DUP).
        virtual void on_message(Instant now, Number client, Bytes payload, bool again) = 0;
        /// The end of a publish of QoS 1 or 2.
        virtual void on_published(Instant now, Number client, PublishId publish, bool accepted) = 0;
        /// A client that cannot join, or that lost its broker: one sentence.
        virtual void on_trouble(Number client, const std::string& why) = 0;
    };

    virtual ~LoadClients() = default;
    virtual void attach(Listener& listener) = 0;
    virtual void join(Number client) = 0;
    /// Nothing when the client cannot take it now.
    virtual std::optional<PublishId> publish(Instant now, Number client, std::uint32_t topic,
                                             Bytes payload) = 0;
    /// Soon this client publishes or receives: what it needs in memory may come nearer meanwhile.
    virtual void expect(Number) {}
    /// Sends what was published, hands over what has come, waits for it until `until` at most.
    virtual void turn(Instant until) = 0;
    virtual void leave() = 0;

    /// Messages of the protocol that were sent again because no answer came.
    [[nodiscard]] virtual std::uint64_t retransmissions() const = 0;
    /// What got lost in this process: the kernel had no room for it at our sockets.
    [[nodiscard]] virtual std::uint64_t dropped_here() const = 0;
    /// Datagrams that came because the broker had sent one for many, if clients listen for such.
    [[nodiscard]] virtual std::optional<std::uint64_t> heard_in_cell() const {
        return std::nullopt;
    }
};

}  // namespace romano::experiments
