#include "broker/net/send_batch.h"

#include <cassert>
#include <cerrno>
#include <cstring>

namespace romano::net {
namespace {

template <typename Info>
std::size_t put_control(MutableBytes room, int level, int type, const Info& info) {
    assert(room.size() >= CMSG_SPACE(sizeof(Info)));
    cmsghdr header{};
    header.cmsg_level = level;
    header.cmsg_type = type;
    header.cmsg_len = CMSG_LEN(sizeof(Info));
    std::memset(room.data(), 0, CMSG_SPACE(sizeof(Info)));
    std::memcpy(room.data(), &header, sizeof header);
    std::memcpy(room.data() + CMSG_LEN(0), &info, sizeof info);
    return CMSG_SPACE(sizeof(Info));
}

std::size_t put_source(MutableBytes room, const Endpoint& source) {
    const SocketAddress address = to_socket_address(source);
    if (source.family == Endpoint::Family::ipv6) {
        in6_pktinfo info{};
        info.ipi6_addr = address.v6.sin6_addr;
        info.ipi6_ifindex = source.scope;
        return put_control(room, IPPROTO_IPV6, IPV6_PKTINFO, info);
    }
    in_pktinfo info{};
    info.ipi_spec_dst = address.v4.sin_addr;
    return put_control(room, IPPROTO_IP, IP_PKTINFO, info);
}

/// For the rare datagram that the path does not take in one piece, on a socket that asks for whole
/// ones (ServiceSocket).
bool send_in_fragments(int socket, const msghdr& datagram) {
    const int cut = IP_PMTUDISC_WANT;
    const int whole = IP_PMTUDISC_DO;
    (void)setsockopt(socket, IPPROTO_IP, IP_MTU_DISCOVER, &cut, sizeof cut);
    const auto sent = sendmsg(socket, &datagram, MSG_DONTWAIT);
    (void)setsockopt(socket, IPPROTO_IP, IP_MTU_DISCOVER, &whole, sizeof whole);
    return sent >= 0;
}

}  // namespace

SendBatch::SendBatch() {
    for (std::size_t i = 0; i < capacity; ++i) {
        headers_[i] = {};
        headers_[i].msg_hdr.msg_iov = &vectors_[i];
        headers_[i].msg_hdr.msg_iovlen = 1;
        headers_[i].msg_hdr.msg_name = &receivers_[i].any;
    }
}

msghdr& SendBatch::append(Bytes octets) {
    assert(!full());
    // sendmmsg takes octets as not const, and leaves them alone.
    vectors_[size_] = {const_cast<std::uint8_t*>(octets.data()), octets.size()};
    msghdr& header = headers_[size_++].msg_hdr;
    header.msg_namelen = 0;
    header.msg_control = nullptr;
    header.msg_controllen = 0;
    return header;
}

void SendBatch::add(const Endpoint& to, Bytes octets) {
    receivers_[size_] = to_socket_address(to);
    const socklen_t size = receivers_[size_].size;
    append(octets).msg_namelen = size;
}

void SendBatch::add_from(const Endpoint& source, const Endpoint& to, Bytes octets) {
    add(to, octets);
    auto& room = controls_[size_ - 1].octets;
    msghdr& header = headers_[size_ - 1].msg_hdr;
    header.msg_control = room.data();
    header.msg_controllen =
        put_source({reinterpret_cast<std::uint8_t*>(room.data()), room.size()}, source);
}

void SendBatch::add_to_peer(Bytes octets) {
    append(octets);
}

void SendBatch::flush(int socket, NetCounters& counters) {
    std::size_t done = 0;
    while (done < size_) {
        const int sent = sendmmsg(socket, headers_.data() + done,
                                  static_cast<unsigned>(size_ - done), MSG_DONTWAIT);
        if (sent > 0) {
            done += static_cast<std::size_t>(sent);
            counters.sent += static_cast<std::uint64_t>(sent);
        } else if (errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS) {
            counters.send_buffer_full += size_ - done;
            break;
        } else if (errno == EMSGSIZE && send_in_fragments(socket, headers_[done].msg_hdr)) {
            ++counters.sent;
            ++done;
        } else if (errno != EINTR) {  // this one cannot be sent; those behind it may
            ++counters.send_failed;
            ++done;
        }
    }
    size_ = 0;
}

}  // namespace romano::net
