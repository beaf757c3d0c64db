// The UDP side of many clients: datagrams in and out by client number, in batches.
//
// A broker tells its clients by their addresses, so each has a socket of its own; or, on the
// loopback network, all share one socket and each has an address of its own (127.1.0.0 and up),
// which costs the load generator far fewer system calls.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "broker/net/net_counters.h"
#include "broker/net/receive_batch.h"
#include "broker/net/send_batch.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"

namespace romano::experiments {

enum class SocketUse : std::uint8_t { one_each, shared };

/// A multicast group where clients listen to what their broker sends once for all of them
/// (romano/mqttsn/cell.md): each with a socket of its own, as robots do.
struct ListenedCell {
    Endpoint group;
    std::uint32_t first;  // the clients from this number on
};

class ClientSockets {
public:
    using Number = std::uint32_t;

    class Listener {
    public:
        virtual ~Listener() = default;
        /// Soon this client gets a datagram: what it needs in memory may come nearer meanwhile.
        virtual void expect(Number client) = 0;
        /// It was read at `now`. The octets live until the call returns.
        virtual void on_datagram(Instant now, Number client, Bytes octets) = 0;
    };

    /// `brokers`: one for all clients, or one for each. Throws std::runtime_error with a sentence.
    /// `shared` needs brokers in 127.0.0.0/8. To a cell only `one_each` listens.
    ClientSockets(std::vector<Endpoint> brokers, Number clients, SocketUse use,
                  const std::optional<ListenedCell>& cell = std::nullopt);
    ~ClientSockets();
    ClientSockets(const ClientSockets&) = delete;
    ClientSockets& operator=(const ClientSockets&) = delete;

    /// Goes out with the next flush(), at the latest. Copies the octets.
    void queue(Number from, Bytes octets);
    void flush();
    /// Hands over what has come; waits for it until `until` at most.
    void receive(Instant until, Listener& listener);

    /// The kernel was told that nobody listens at the broker's address (ICMP).
    [[nodiscard]] bool was_refused() const { return was_refused_; }
    [[nodiscard]] std::uint64_t not_sent() const {
        return counters_.send_buffer_full + counters_.send_failed;
    }
    /// Datagrams that came and found no room at our sockets.
    [[nodiscard]] std::uint64_t dropped() const;
    /// Datagrams that came by the cell, one for each client that heard one.
    [[nodiscard]] std::uint64_t heard_in_cell() const { return heard_in_cell_; }

private:
    struct Waiting {
        Number from;
        std::uint32_t offset;
        std::uint32_t size;
    };

    void open_one_each();
    void open_shared();
    void listen_to(const ListenedCell& cell);
    int open(const Endpoint& broker);
    void watch(int socket, Number number);
    void read(Number socket, Listener& listener);
    [[nodiscard]] Number receiver_of(Number socket, std::size_t slot) const;
    [[nodiscard]] Endpoint source_of(Number client) const;
    [[nodiscard]] const Endpoint& broker_of(Number client) const {
        return brokers_.size() == 1 ? brokers_.front() : brokers_[client];
    }

    std::vector<Endpoint> brokers_;
    Number clients_;
    SocketUse use_;
    int epoll_ = -1;
    std::vector<int> sockets_;  // by client; or the one; behind them those that listen to a cell
    Number first_listener_ = 0;
    Endpoint shared_at_;
    std::unique_ptr<net::ReceiveBatch> incoming_ = std::make_unique<net::ReceiveBatch>();
    std::array<Number, net::ReceiveBatch::capacity> receivers_{};  // of what was read last
    std::unique_ptr<net::SendBatch> outgoing_ = std::make_unique<net::SendBatch>();
    std::vector<Waiting> waiting_;
    std::vector<std::uint8_t> octets_;  // of what waits
    net::NetCounters counters_;
    std::uint64_t heard_in_cell_ = 0;
    bool was_refused_ = false;
};

}  // namespace romano::experiments
