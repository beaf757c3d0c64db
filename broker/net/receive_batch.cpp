#include "broker/net/receive_batch.h"

#include <cerrno>
#include <cstring>

namespace romano::net {

ReceiveBatch::ReceiveBatch()
    : storage_(std::make_unique_for_overwrite<std::uint8_t[]>(capacity * slot_octets)) {
    for (std::size_t i = 0; i < capacity; ++i) {
        vectors_[i] = {storage_.get() + i * slot_octets, slot_octets};
        headers_[i] = {};
        headers_[i].msg_hdr.msg_iov = &vectors_[i];
        headers_[i].msg_hdr.msg_iovlen = 1;
        headers_[i].msg_hdr.msg_name = &senders_[i].any;
        headers_[i].msg_hdr.msg_control = controls_[i].octets.data();
    }
}

std::size_t ReceiveBatch::read(int socket) {
    for (std::size_t i = 0; i < used_; ++i) {
        headers_[i].msg_hdr.msg_namelen = sizeof(sockaddr_in6);
        headers_[i].msg_hdr.msg_controllen = control_octets;
    }
    used_ = 0;
    int count = 0;
    do {
        count = recvmmsg(socket, headers_.data(), capacity, MSG_DONTWAIT, nullptr);
    } while (count < 0 && errno == EINTR);
    // An error (a network that went down, say) belongs to no datagram: the next wait tells again.
    if (count > 0) used_ = static_cast<std::size_t>(count);
    return used_;
}

Bytes ReceiveBatch::octets(std::size_t slot) const {
    return {storage_.get() + slot * slot_octets, headers_[slot].msg_len};
}

Endpoint ReceiveBatch::from(std::size_t slot) const {
    return to_endpoint(senders_[slot]);
}

Endpoint ReceiveBatch::to(std::size_t slot, const Endpoint& bound) const {
    const msghdr& header = headers_[slot].msg_hdr;
    for (cmsghdr* c = CMSG_FIRSTHDR(&header); c != nullptr;
         c = CMSG_NXTHDR(const_cast<msghdr*>(&header), c)) {
        if (c->cmsg_level == IPPROTO_IP && c->cmsg_type == IP_PKTINFO) {
            in_pktinfo info{};
            std::memcpy(&info, CMSG_DATA(c), sizeof info);
            return to_endpoint(info.ipi_addr, bound.port);
        }
        if (c->cmsg_level == IPPROTO_IPV6 && c->cmsg_type == IPV6_PKTINFO) {
            in6_pktinfo info{};
            std::memcpy(&info, CMSG_DATA(c), sizeof info);
            return to_endpoint(info.ipi6_addr, bound.port, info.ipi6_ifindex);
        }
    }
    return bound;
}

}  // namespace romano::net
