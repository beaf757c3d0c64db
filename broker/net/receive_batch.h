// Up to `capacity` datagrams read with one recvmmsg.
//
// Each slot takes the largest datagram there is. The pages behind a slot become resident only as
// far as datagrams reach into them, so that small messages keep the memory small.
#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include "broker/net/socket_address.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"

namespace romano::net {

class ReceiveBatch {
public:
    static constexpr std::size_t capacity = 64;

    ReceiveBatch();
    ReceiveBatch(const ReceiveBatch&) = delete;
    ReceiveBatch& operator=(const ReceiveBatch&) = delete;

    /// Reads what is there, without waiting. Returns how many datagrams that are.
    [[nodiscard]] std::size_t read(int socket);

    [[nodiscard]] Bytes octets(std::size_t slot) const;
    [[nodiscard]] Endpoint from(std::size_t slot) const;
    /// The address that the datagram was sent to, for sockets with packet information; else
    /// `bound`, the address of the socket.
    [[nodiscard]] Endpoint to(std::size_t slot, const Endpoint& bound) const;

private:
    static constexpr std::size_t slot_octets = 65'536;
    static constexpr std::size_t control_octets = 128;
    struct alignas(cmsghdr) Control {
        std::array<char, control_octets> octets;
    };

    std::unique_ptr<std::uint8_t[]> storage_;
    std::array<SocketAddress, capacity> senders_;
    std::array<Control, capacity> controls_;
    std::array<iovec, capacity> vectors_;
    std::array<mmsghdr, capacity> headers_;
    std::size_t used_ = capacity;  // slots whose headers the last read changed
};

}  // namespace romano::net
