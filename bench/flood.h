// A stranger who floods a broker with forged datagrams while a load goes on. They leave one by one,
// evenly, between the load's own turns: a machine of two cores has none for a stranger.
#pragma once

#include <cstdint>
#include <vector>

#include "experiments/load/mqttsn_clients.h"
#include "romano/base/time.h"

namespace romano::bench {

/// What costs a broker most at each kind of listener.
enum class Forgery {
    publish,  // plain: from a thousand addresses that have no session
    connect,  // plain, of a broker with keys: likewise, in the name of a client that has one
    packet,   // protected: the header of a client's packet, with a number that was not there yet
    record,   // DTLS: of a client's address, with a number that was not there yet
    hello,    // DTLS: a handshake's beginning, from a thousand addresses
};

class Flood {
public:
    /// `clients` share a socket.
    Flood(experiments::MqttsnClients& clients, std::uint32_t number_of_clients, Forgery forgery,
          double per_s);

    /// As often as possible: what is due leaves.
    void go_on(Instant now);
    [[nodiscard]] std::uint64_t sent() const { return sent_; }

private:
    [[nodiscard]] std::uint32_t next_sender() const;

    experiments::MqttsnClients& clients_;
    std::uint32_t number_of_clients_;
    Forgery forgery_;
    double per_s_;
    std::vector<std::uint8_t> datagram_;
    std::size_t number_at_ = 0;  // where its 32-bit number stands
    std::uint32_t number_ = 1U << 30U;
    Instant began_ = never;
    std::uint64_t sent_ = 0;
};

}  // namespace romano::bench
