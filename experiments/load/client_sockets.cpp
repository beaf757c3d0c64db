#include "experiments/load/client_sockets.h"

#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

#include "broker/net/clock.h"
#include "broker/net/socket_address.h"
#include "experiments/load/ready_sockets.h"

namespace romano::experiments {
namespace {

constexpr int buffer_octets = 8 * 1024 * 1024;

[[noreturn]] void fail(const std::string& what) {
    throw std::runtime_error(what + ": " + std::strerror(errno));
}

void enlarge(int socket, int forced, int asked) {
    if (::setsockopt(socket, SOL_SOCKET, forced, &buffer_octets, sizeof buffer_octets) == 0) return;
    (void)::setsockopt(socket, SOL_SOCKET, asked, &buffer_octets, sizeof buffer_octets);
}

/// A few more than the clients: the program has files of its own.
void allow_open_files(std::uint32_t clients, std::size_t sockets) {
    rlimit limit{};
    const rlim_t wanted = sockets + 64;
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= wanted) return;
    limit.rlim_cur = wanted;
    limit.rlim_max = std::max(limit.rlim_max, wanted);
    if (::setrlimit(RLIMIT_NOFILE, &limit) == 0) return;
    fail(std::to_string(clients) + " clients need " + std::to_string(sockets) +
         " open files (ulimit -n)");
}

/// On the interface by which the client's own socket goes out.
bool join(int socket, const net::SocketAddress& group, int own) {
    if (group.any.sa_family == AF_INET6) {
        const ipv6_mreq request{.ipv6mr_multiaddr = group.v6.sin6_addr,
                                .ipv6mr_interface = group.v6.sin6_scope_id};
        return ::setsockopt(socket, IPPROTO_IPV6, IPV6_ADD_MEMBERSHIP, &request, sizeof request) ==
               0;
    }
    net::SocketAddress local;
    local.size = sizeof local.v6;
    if (::getsockname(own, &local.any, &local.size) != 0) return false;
    const ip_mreqn request{
        .imr_multiaddr = group.v4.sin_addr, .imr_address = local.v4.sin_addr, .imr_ifindex = 0};
    return ::setsockopt(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0;
}

}  // namespace

ClientSockets::ClientSockets(std::vector<Endpoint> brokers, Number clients, SocketUse use,
                             const std::optional<ListenedCell>& cell)
    : brokers_(std::move(brokers)), clients_(clients), use_(use) {
    allow_open_files(clients,
                     (use == SocketUse::shared ? 1 : clients) + (cell ? clients - cell->first : 0));
    epoll_ = ::epoll_create1(EPOLL_CLOEXEC);
    if (epoll_ < 0) fail("cannot wait for sockets");
    if (use == SocketUse::shared) {
        open_shared();
    } else {
        open_one_each();
    }
    if (cell) listen_to(*cell);
}

ClientSockets::~ClientSockets() {
    for (const int socket : sockets_) ::close(socket);
    ::close(epoll_);
}

int ClientSockets::open(const Endpoint& broker) {
    const bool v6 = broker.family == Endpoint::Family::ipv6;
    const int socket =
        ::socket(v6 ? AF_INET6 : AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (socket < 0) fail("cannot open a socket");
    sockets_.push_back(socket);
    enlarge(socket, SO_RCVBUFFORCE, SO_RCVBUF);
    enlarge(socket, SO_SNDBUFFORCE, SO_SNDBUF);
    if (!v6) {  // as the broker's own sockets, and for the same reason
        const int whole = IP_PMTUDISC_DO;
        (void)::setsockopt(socket, IPPROTO_IP, IP_MTU_DISCOVER, &whole, sizeof whole);
    }
    return socket;
}

void ClientSockets::watch(int socket, Number number) {
    epoll_event event{.events = EPOLLIN, .data = {.u32 = number}};
    if (::epoll_ctl(epoll_, EPOLL_CTL_ADD, socket, &event) != 0) fail("cannot wait for a socket");
}

void ClientSockets::open_one_each() {
    for (Number client = 0; client < clients_; ++client) {
        const net::SocketAddress to = net::to_socket_address(broker_of(client));
        const int socket = open(broker_of(client));
        if (::connect(socket, &to.any, to.size) != 0) fail("cannot reach the broker's address");
        watch(socket, client);
    }
}

void ClientSockets::listen_to(const ListenedCell& cell) {
    first_listener_ = cell.first;
    const net::SocketAddress group = net::to_socket_address(cell.group);
    for (Number client = cell.first; client < clients_; ++client) {
        const int socket = open(cell.group);
        const int on = 1;  // all of them, and robots on this machine
        if (::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
            ::bind(socket, &group.any, group.size) != 0 || !join(socket, group, sockets_[client])) {
            fail("cannot listen to the cell's group");
        }
        watch(socket, static_cast<Number>(sockets_.size() - 1));
    }
}

void ClientSockets::open_shared() {
    const auto is_loopback = [](const Endpoint& broker) {
        return broker.family == Endpoint::Family::ipv4 && broker.address[0] == 127;
    };
    if (!std::ranges::all_of(brokers_, is_loopback)) {
        throw std::runtime_error("clients can share a socket only if the broker is on 127.0.0.0/8");
    }
    const int socket = open(brokers_.front());
    const int on = 1;
    if (::setsockopt(socket, IPPROTO_IP, IP_PKTINFO, &on, sizeof on) != 0) {
        fail("cannot tell addresses of one socket apart");
    }
    net::SocketAddress any = net::to_socket_address({.family = Endpoint::Family::ipv4});
    if (::bind(socket, &any.any, any.size) != 0) fail("cannot bind a socket");
    any.size = sizeof any.v6;
    if (::getsockname(socket, &any.any, &any.size) != 0) fail("cannot bind a socket");
    shared_at_ = net::to_endpoint(any);
    watch(socket, 0);
}

/// 127.1.0.0 and up.
Endpoint ClientSockets::source_of(Number client) const {
    Endpoint source = shared_at_;
    source.address[0] = 127;
    source.address[1] = static_cast<std::uint8_t>(1 + (client >> 16U));
    source.address[2] = static_cast<std::uint8_t>(client >> 8U);
    source.address[3] = static_cast<std::uint8_t>(client);
    return source;
}

void ClientSockets::queue(Number from, Bytes octets) {
    if (waiting_.size() == net::SendBatch::capacity) flush();
    waiting_.push_back({from, static_cast<std::uint32_t>(octets_.size()),
                        static_cast<std::uint32_t>(octets.size())});
    octets_.insert(octets_.end(), octets.begin(), octets.end());
}

void ClientSockets::flush() {
    for (std::size_t i = 0; i < waiting_.size(); ++i) {
        const Waiting& datagram = waiting_[i];
        const Bytes octets = Bytes{octets_}.subspan(datagram.offset, datagram.size);
        if (use_ == SocketUse::shared) {
            outgoing_->add_from(source_of(datagram.from), broker_of(datagram.from), octets);
            continue;
        }
        outgoing_->add_to_peer(octets);
        const bool last = i + 1 == waiting_.size() || waiting_[i + 1].from != datagram.from;
        if (last) outgoing_->flush(sockets_[datagram.from], counters_);
    }
    if (!outgoing_->empty()) outgoing_->flush(sockets_.front(), counters_);
    waiting_.clear();
    octets_.clear();
}

void ClientSockets::receive(Instant until, Listener& listener) {
    std::array<epoll_event, 64> room{};
    for (const epoll_event& event : wait_for_sockets(epoll_, until, room)) {
        if ((event.events & EPOLLERR) != 0) {
            int error = 0;
            socklen_t size = sizeof error;
            ::getsockopt(sockets_[event.data.u32], SOL_SOCKET, SO_ERROR, &error, &size);
            was_refused_ = was_refused_ || error == ECONNREFUSED;
        }
        read(event.data.u32, listener);
    }
}

void ClientSockets::read(Number socket, Listener& listener) {
    const std::size_t count = incoming_->read(sockets_[socket]);
    const Instant now = net::now();
    for (std::size_t slot = 0; slot < count; ++slot) {
        receivers_[slot] = receiver_of(socket, slot);
        if (receivers_[slot] < clients_) listener.expect(receivers_[slot]);
    }
    for (std::size_t slot = 0; slot < count; ++slot) {
        if (receivers_[slot] >= clients_) continue;
        if (use_ == SocketUse::one_each && socket >= clients_) ++heard_in_cell_;
        listener.on_datagram(now, receivers_[slot], incoming_->octets(slot));
    }
}

/// None of the clients when it came from somebody else than the client's broker.
ClientSockets::Number ClientSockets::receiver_of(Number socket, std::size_t slot) const {
    if (use_ == SocketUse::one_each) {
        if (socket < clients_) return socket;
        const Number listener = first_listener_ + (socket - clients_);
        return incoming_->from(slot) == broker_of(listener) ? listener : clients_;
    }
    const auto to = incoming_->to(slot, shared_at_).address;
    const Number client = (to[1] - 1U) << 16U | Number{to[2]} << 8U | to[3];
    if (client >= clients_ || incoming_->from(slot) != broker_of(client)) return clients_;
    return client;
}

std::uint64_t ClientSockets::dropped() const {
    std::uint64_t sum = 0;
    for (const int socket : sockets_) {
        std::array<std::uint32_t, 9> memory{};  // SK_MEMINFO_DROPS is the last of linux/sock_diag.h
        socklen_t size = sizeof memory;
        if (::getsockopt(socket, SOL_SOCKET, SO_MEMINFO, memory.data(), &size) == 0) {
            sum += memory.back();
        }
    }
    return sum;
}

}  // namespace romano::experiments
