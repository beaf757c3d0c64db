#include "broker/net/service_socket.h"

#include <cerrno>
#include <cstring>

#include "broker/net/interface_address.h"
#include "broker/net/last_error.h"

namespace romano::net {
namespace {

// Asks for this much; the kernel gives what net.core.rmem_max and wmem_max allow, all of it to
// root.
constexpr int buffer_octets = 8 * 1024 * 1024;

template <typename T>
boost::system::error_code set_option(int socket, int level, int name, const T& value) {
    if (setsockopt(socket, level, name, &value, sizeof value) == 0) return {};
    return last_error();
}

}  // namespace

boost::system::error_code ServiceSocket::open(const Endpoint& address, Bind how) {
    wildcard_ = is_wildcard(address);
    if (auto error = create(address)) return error;
    if (wildcard_) {
        if (auto error = ask_for_packet_information()) return error;
    }
    return bind(address, how);
}

boost::system::error_code ServiceSocket::join(const Endpoint& group, const Endpoint& local) {
    if (auto error = create(group)) return error;
    if (auto error = bind(group, Bind::beside)) return error;
    const int fd = socket_.native_handle();
    const SocketAddress to = to_socket_address(group);
    if (group.family == Endpoint::Family::ipv6) {
        ipv6_mreq request{};
        request.ipv6mr_multiaddr = to.v6.sin6_addr;
        request.ipv6mr_interface = group.scope != 0 ? group.scope : local.scope;
        return set_option(fd, IPPROTO_IPV6, IPV6_ADD_MEMBERSHIP, request);
    }
    ip_mreqn request{};
    request.imr_multiaddr = to.v4.sin_addr;
    request.imr_address = to_socket_address(local).v4.sin_addr;
    if (!is_wildcard(local)) return set_option(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, request);
    auto error = make_error_code(boost::system::errc::no_such_device);
    bool heard_somewhere = false;
    for (const std::uint32_t link : links_of(local)) {
        request.imr_ifindex = static_cast<int>(link);
        error = set_option(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, request);
        heard_somewhere = heard_somewhere || !error;
    }
    return heard_somewhere ? boost::system::error_code{} : error;
}

boost::system::error_code ServiceSocket::create(const Endpoint& address) {
    boost::system::error_code error;
    const bool v6 = address.family == Endpoint::Family::ipv6;
    socket_.open(v6 ? boost::asio::ip::udp::v6() : boost::asio::ip::udp::v4(), error);
    if (error) return error;
    enlarge_buffers();
    const int fd = socket_.native_handle();
    // [::] means IPv6 alone, so that 0.0.0.0 can be served beside it.
    if (v6) return set_option(fd, IPPROTO_IPV6, IPV6_V6ONLY, 1);
    // A datagram that may not be cut up needs no id from the kernel's table of destinations, which
    // costs more than all that the broker does with a message. SendBatch sends the longer ones.
    // (Multicasts need no option: Linux sends them by the interface of the socket's address.)
    return set_option(fd, IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_DO);
}

boost::system::error_code ServiceSocket::bind(const Endpoint& address, Bind how) {
    const int fd = socket_.native_handle();
    if (how == Bind::beside) {
        if (auto error = set_option(fd, SOL_SOCKET, SO_REUSEADDR, 1)) return error;
    }
    const SocketAddress wanted = to_socket_address(address);
    if (::bind(fd, &wanted.any, wanted.size) != 0) return last_error();
    SocketAddress got;
    got.size = sizeof(sockaddr_in6);
    if (getsockname(fd, &got.any, &got.size) != 0) return last_error();
    bound_ = to_endpoint(got);
    bound_.packets = address.packets;
    return set_option(fd, SOL_SOCKET, SO_REUSEADDR, 1);
}

boost::system::error_code ServiceSocket::ask_for_packet_information() {
    boost::system::error_code error;
    const bool v6 = socket_.local_endpoint(error).protocol() == boost::asio::ip::udp::v6();
    if (error) return error;
    const int fd = socket_.native_handle();
    return v6 ? set_option(fd, IPPROTO_IPV6, IPV6_RECVPKTINFO, 1)
              : set_option(fd, IPPROTO_IP, IP_PKTINFO, 1);
}

void ServiceSocket::enlarge_buffers() {
    const int fd = socket_.native_handle();
    if (set_option(fd, SOL_SOCKET, SO_RCVBUFFORCE, buffer_octets)) {
        (void)set_option(fd, SOL_SOCKET, SO_RCVBUF, buffer_octets);
    }
    if (set_option(fd, SOL_SOCKET, SO_SNDBUFFORCE, buffer_octets)) {
        (void)set_option(fd, SOL_SOCKET, SO_SNDBUF, buffer_octets);
    }
}

bool ServiceSocket::covers(const Endpoint& address) const {
    if (address == bound_) return true;
    return wildcard_ && address.family == bound_.family && address.port == bound_.port &&
           address.packets == bound_.packets;
}

std::size_t ServiceSocket::read(ReceiveBatch& batch) {
    return batch.read(socket_.native_handle());
}

Endpoint ServiceSocket::via(const ReceiveBatch& batch, std::size_t slot) const {
    if (!wildcard_) return bound_;
    Endpoint to = batch.to(slot, bound_);
    to.packets = bound_.packets;
    return to;
}

void ServiceSocket::queue(const Endpoint& via, const Endpoint& to, Bytes octets,
                          NetCounters& counters) {
    if (outgoing_.full()) flush(counters);
    queued_for_.set(to.hash() % queued_for_.size());
    if (wildcard_ && !is_wildcard(via)) {
        outgoing_.add_from(via, to, octets);
    } else {
        outgoing_.add(to, octets);
    }
}

void ServiceSocket::flush(NetCounters& counters) {
    if (outgoing_.empty()) return;
    outgoing_.flush(socket_.native_handle(), counters);
    queued_for_.reset();
}

}  // namespace romano::net
