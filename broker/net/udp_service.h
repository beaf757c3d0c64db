// The service addresses of a broker: datagrams in, actions out, in batches.
//
// Reads a batch with one recvmmsg, hands each datagram over, then lets the owner flush what came
// of all of them, one sendmmsg a socket. Addresses come and go at run time. One thread: that of
// the io_context. In the steady state nothing here allocates.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/system/error_code.hpp>
#include <memory>
#include <utility>
#include <vector>

#include "broker/core/actions.h"
#include "broker/net/net_counters.h"
#include "broker/net/receive_batch.h"
#include "broker/net/service_socket.h"
#include "broker/net/turn_clock.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::net {

/// Who gets the datagrams.
class DatagramHandler {
public:
    virtual ~DatagramHandler() = default;
    /// A datagram from `from` to our address `via`; the octets live until the call returns.
    virtual void on_datagram(const Endpoint& via, const Endpoint& from, Bytes octets) = 0;
    /// That was the last one of a batch: time to send the answers.
    virtual void on_batch_end() = 0;
};

class UdpService {
public:
    UdpService(boost::asio::io_context& io, DatagramHandler& handler);
    ~UdpService();
    UdpService(const UdpService&) = delete;
    UdpService& operator=(const UdpService&) = delete;

    /// Serves `address`. On success `bound`, if given, gets the address with the port that was
    /// chosen for port 0. Serving an address that is served already is fine; beside others it is
    /// bound anew, so that its datagrams come here again.
    [[nodiscard]] boost::system::error_code open(const Endpoint& address, Bind how,
                                                 Endpoint* bound = nullptr);
    /// Stops serving it; what was not read is lost, as with any UDP socket that closes.
    void close(const Endpoint& address);

    /// Listens to a discovery group and sends Multicasts there, in the name of the first service
    /// address of its family. That address must be served already. A group of IPv6's links
    /// (ff02::...) without an interface is that of each link on which the address is served.
    [[nodiscard]] boost::system::error_code join(const Endpoint& group);

    /// Carries out Send and Multicast, in order for each receiver. Appends and Forwards are the
    /// cluster's.
    void carry_out(const broker::Actions& actions);

    [[nodiscard]] bool serves(const Endpoint& address) const;
    [[nodiscard]] std::vector<Endpoint> addresses() const;
    [[nodiscard]] const NetCounters& counters() const { return counters_; }

private:
    class Channel;

    /// Reads what came there before its successor was bound.
    void retire(const std::shared_ptr<Channel>& channel);
    [[nodiscard]] boost::system::error_code join_as(const Endpoint& self, const Endpoint& group);
    void wait(const std::shared_ptr<Channel>& channel);
    void read(const std::shared_ptr<Channel>& channel);
    [[nodiscard]] ServiceSocket* socket_of(const Endpoint& via);
    [[nodiscard]] const Endpoint* first_address(Endpoint::Family family) const;
    /// What waits for that receiver at other sockets leaves first.
    void keep_order(const Endpoint& to, const ServiceSocket* socket);
    void multicast(Bytes octets);
    void flush();

    boost::asio::io_context& io_;
    TurnClock& turns_;
    DatagramHandler& handler_;
    std::unique_ptr<ReceiveBatch> batch_;
    std::vector<std::shared_ptr<Channel>> services_;
    std::vector<std::shared_ptr<Channel>> groups_;
    std::vector<std::shared_ptr<Channel>> retired_;
    NetCounters counters_;
};

}  // namespace romano::net
