// One UDP socket on a service address.
//
// The first bind of an address is exclusive, so that a stranger on the port is noticed; afterwards
// the socket lets others bind beside it, because a peer may have to take the address over from a
// stopped process. Of several sockets on one address Linux gives the datagrams to the newest.
#pragma once

#include <bitset>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/system/error_code.hpp>
#include <utility>

#include "broker/net/net_counters.h"
#include "broker/net/receive_batch.h"
#include "broker/net/send_batch.h"
#include "romano/base/endpoint.h"

namespace romano::net {

enum class Bind {
    alone,   // fails when somebody has the address
    beside,  // also when another process has it, if that one allows it
};

class ServiceSocket {
public:
    explicit ServiceSocket(boost::asio::io_context& io) : socket_(io) {}

    /// Port 0 takes a free one; see bound().
    [[nodiscard]] boost::system::error_code open(const Endpoint& address, Bind bind);

    /// As open(), for the multicast group `group` on the interface that has the address `local`.
    [[nodiscard]] boost::system::error_code join(const Endpoint& group, const Endpoint& local);

    [[nodiscard]] const Endpoint& bound() const { return bound_; }
    /// True when datagrams that come to, or leave from, this address use this socket.
    [[nodiscard]] bool covers(const Endpoint& address) const;

    [[nodiscard]] std::size_t read(ReceiveBatch& batch);
    /// The service address that a received datagram was sent to.
    [[nodiscard]] Endpoint via(const ReceiveBatch& batch, std::size_t slot) const;

    void queue(const Endpoint& via, const Endpoint& to, Bytes octets, NetCounters& counters);
    void flush(NetCounters& counters);
    /// Something for that receiver is queued, perhaps.
    [[nodiscard]] bool may_hold_for(const Endpoint& to) const {
        return queued_for_[to.hash() % queued_for_.size()];
    }

    template <typename Handler>
    void async_wait_readable(Handler handler) {
        socket_.async_wait(boost::asio::ip::udp::socket::wait_read, std::move(handler));
    }

private:
    [[nodiscard]] boost::system::error_code create(const Endpoint& address);
    [[nodiscard]] boost::system::error_code bind(const Endpoint& address, Bind how);
    [[nodiscard]] boost::system::error_code ask_for_packet_information();
    void enlarge_buffers();

    boost::asio::ip::udp::socket socket_;
    Endpoint bound_;
    bool wildcard_ = false;
    SendBatch outgoing_;
    std::bitset<2048> queued_for_;  // by the receivers' hashes
};

}  // namespace romano::net
