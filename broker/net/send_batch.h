// Datagrams of one socket that wait for one sendmmsg.
//
// Holds views of the octets, not copies: they must live until flush(). When the socket's buffer is
// full the rest of the batch is dropped and counted: waiting would stop the broker for everybody,
// and what matters (QoS 1 and 2) is sent again.
#pragma once

#include <array>
#include <cstddef>

#include "broker/net/net_counters.h"
#include "broker/net/socket_address.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::net {

class SendBatch {
public:
    static constexpr std::size_t capacity = 128;

    SendBatch();
    SendBatch(const SendBatch&) = delete;
    SendBatch& operator=(const SendBatch&) = delete;

    [[nodiscard]] bool full() const { return size_ == capacity; }
    [[nodiscard]] bool empty() const { return size_ == 0; }

    void add(const Endpoint& to, Bytes octets);
    /// As add(), leaving from the address `source` of a socket that is bound to all addresses.
    void add_from(const Endpoint& source, const Endpoint& to, Bytes octets);
    /// As add(), to the address that the socket is connected to.
    void add_to_peer(Bytes octets);

    /// Sends all and is empty again.
    void flush(int socket, NetCounters& counters);

private:
    msghdr& append(Bytes octets);

    struct alignas(cmsghdr) Control {
        std::array<char, 64> octets;
    };

    std::array<SocketAddress, capacity> receivers_;
    std::array<Control, capacity> controls_;
    std::array<iovec, capacity> vectors_;
    std::array<mmsghdr, capacity> headers_;
    std::size_t size_ = 0;
};

}  // namespace romano::net
