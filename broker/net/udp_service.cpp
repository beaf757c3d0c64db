#include "broker/net/udp_service.h"

#include <algorithm>
#include <boost/asio/post.hpp>
#include <utility>
#include <variant>

#include "broker/net/clock.h"
#include "broker/net/interface_address.h"

namespace romano::net {

// Shared with the pending wait, so that an address can be given up while its socket is being read.
class UdpService::Channel {
public:
    explicit Channel(boost::asio::io_context& io) : socket(io) {}

    ServiceSocket socket;
    Endpoint speaks_as;  // a group's: the service address that answers; else family none
    bool closed = false;
};

UdpService::UdpService(boost::asio::io_context& io, DatagramHandler& handler)
    : io_(io),
      turns_(TurnClock::of(io)),
      handler_(handler),
      batch_(std::make_unique<ReceiveBatch>()) {}

UdpService::~UdpService() {
    for (const auto& channel : services_) channel->closed = true;
    for (const auto& channel : groups_) channel->closed = true;
}

boost::system::error_code UdpService::open(const Endpoint& address, Bind how, Endpoint* bound) {
    const auto served = std::ranges::find_if(
        services_, [&](const auto& channel) { return channel->socket.bound() == address; });
    if (served != services_.end() && how == Bind::alone) {
        if (bound != nullptr) *bound = address;
        return {};
    }
    auto channel = std::make_shared<Channel>(io_);
    if (auto error = channel->socket.open(address, how)) return error;
    if (bound != nullptr) *bound = channel->socket.bound();
    wait(channel);
    if (served == services_.end()) {
        services_.push_back(std::move(channel));
    } else {
        retire(std::exchange(*served, std::move(channel)));
    }
    return {};
}

void UdpService::retire(const std::shared_ptr<Channel>& channel) {
    retired_.push_back(channel);
    boost::asio::post(io_, [this, weak = std::weak_ptr(channel)] {
        const auto former = weak.lock();
        if (!former || former->closed) return;
        read(former);
        former->closed = true;
        std::erase(retired_, former);
    });
}

void UdpService::close(const Endpoint& address) {
    const auto at = std::ranges::find_if(
        services_, [&](const auto& channel) { return channel->socket.bound() == address; });
    if (at == services_.end()) return;
    (*at)->closed = true;
    services_.erase(at);
    std::erase_if(retired_, [&](const auto& former) {
        if (former->socket.bound() != address) return false;
        former->closed = true;
        return true;
    });
}

boost::system::error_code UdpService::join(const Endpoint& group) {
    const Endpoint* self = first_address(group.family);
    if (self == nullptr) {
        return make_error_code(boost::system::errc::address_family_not_supported);
    }
    if (!is_link_group(group) || group.scope != 0) return join_as(*self, group);
    auto error = make_error_code(boost::system::errc::no_such_device);
    bool heard_somewhere = false;
    for (const std::uint32_t link : links_of(*self)) {
        Endpoint here = group;
        here.scope = link;
        error = join_as(*self, here);
        heard_somewhere = heard_somewhere || !error;
    }
    return heard_somewhere ? boost::system::error_code{} : error;
}

boost::system::error_code UdpService::join_as(const Endpoint& self, const Endpoint& group) {
    auto channel = std::make_shared<Channel>(io_);
    channel->speaks_as = self;
    if (auto error = channel->socket.join(group, self)) return error;
    groups_.push_back(channel);
    wait(channel);
    return {};
}

void UdpService::wait(const std::shared_ptr<Channel>& channel) {
    channel->socket.async_wait_readable(
        [this, weak = std::weak_ptr(channel)](const boost::system::error_code& error) {
            const auto ready = weak.lock();
            if (error || !ready || ready->closed) return;
            turns_.begin(now());
            read(ready);
            if (!ready->closed) wait(ready);
        });
}

void UdpService::read(const std::shared_ptr<Channel>& channel) {
    // Several full batches in a row save a trip through the reactor; the bound lets timers and
    // peers have their turn under full load.
    constexpr int most_batches = 4;
    for (int round = 0; round < most_batches; ++round) {
        const std::size_t count = channel->socket.read(*batch_);
        const Instant began = now();
        counters_.received += count;
        for (std::size_t slot = 0; slot < count && !channel->closed; ++slot) {
            const bool group = channel->speaks_as.family != Endpoint::Family::none;
            handler_.on_datagram(group ? channel->speaks_as : channel->socket.via(*batch_, slot),
                                 batch_->from(slot), batch_->octets(slot));
        }
        if (count > 0) {
            handler_.on_batch_end();
            counters_.handling.add(now() - began, count);
        }
        if (count < ReceiveBatch::capacity || channel->closed) return;
    }
}

void UdpService::carry_out(const broker::Actions& actions) {
    for (const broker::Action& action : actions.list()) {
        if (const auto* send = std::get_if<broker::Send>(&action)) {
            if (send->via.family == Endpoint::Family::none) continue;  // it could not be sealed
            if (ServiceSocket* socket = socket_of(send->via)) {
                keep_order(send->to.endpoint, socket);
                socket->queue(send->via, send->to.endpoint, actions.octets(*send), counters_);
            } else {
                ++counters_.no_such_socket;
            }
        } else if (const auto* all = std::get_if<broker::Multicast>(&action)) {
            multicast(actions.octets(*all));
        }
    }
    flush();
}

void UdpService::keep_order(const Endpoint& to, const ServiceSocket* socket) {
    if (services_.size() < 2) return;
    for (const auto& channel : services_) {
        ServiceSocket& other = channel->socket;
        if (&other != socket && other.may_hold_for(to)) other.flush(counters_);
    }
}

void UdpService::multicast(Bytes octets) {
    for (const auto& group : groups_) {
        if (ServiceSocket* socket = socket_of(group->speaks_as)) {
            socket->queue(group->speaks_as, group->socket.bound(), octets, counters_);
        }
    }
}

void UdpService::flush() {
    for (const auto& channel : services_) channel->socket.flush(counters_);
}

ServiceSocket* UdpService::socket_of(const Endpoint& via) {
    // An address of its own goes before one that a socket on all addresses covers too.
    ServiceSocket* covering = nullptr;
    for (const auto& channel : services_) {
        if (channel->socket.bound() == via) return &channel->socket;
        if (channel->socket.covers(via)) covering = &channel->socket;
    }
    return covering;
}

const Endpoint* UdpService::first_address(Endpoint::Family family) const {
    for (const auto& channel : services_) {
        if (channel->socket.bound().family == family) return &channel->socket.bound();
    }
    return nullptr;
}

bool UdpService::serves(const Endpoint& address) const {
    return std::ranges::any_of(
        services_, [&](const auto& channel) { return channel->socket.covers(address); });
}

std::vector<Endpoint> UdpService::addresses() const {
    std::vector<Endpoint> out;
    for (const auto& channel : services_) out.push_back(channel->socket.bound());
    return out;
}

}  // namespace romano::net
