#include "overlay/link/link_service.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "broker/net/asio_endpoint.h"
#include "overlay/link/guest.h"
#include "overlay/link/watch.h"

namespace romano::link {

using boost::asio::ip::tcp;
using boost::system::error_code;

LinkService::LinkService(boost::asio::io_context& io, const broker::LogId& self, OnLink on_link)
    : io_(io), self_(self), on_link_(std::move(on_link)), acceptor_(io), pause_(io) {}

LinkService::~LinkService() {
    for (const auto& [broker, watch] : watches_) watch->stop();
    for (const auto& guest : guests_) guest->stop();
}

error_code LinkService::open(const Endpoint& host) {
    Endpoint wanted = host;
    wanted.port = 0;
    const tcp::endpoint endpoint = net::to_asio<tcp>(wanted);
    error_code error;
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(boost::asio::socket_base::max_listen_connections, error);
    if (error) return error;
    const auto bound = acceptor_.local_endpoint(error);
    if (error) return error;
    address_ = host;
    address_.port = bound.port();
    accept();
    return {};
}

void LinkService::accept() {
    acceptor_.async_accept([this](const error_code& error, tcp::socket socket) {
        if (error == boost::asio::error::operation_aborted) return;
        if (error) return accept_later();  // out of file descriptors, for example
        if (guests_.size() < most_guests) {
            const auto guest = std::make_shared<Guest>(*this, std::move(socket));
            guests_.insert(guest);
            guest->receive();
        } else {
            ++counters_.too_many;
        }
        accept();
    });
}

void LinkService::accept_later() {
    pause_.expires_after(std::chrono::milliseconds{100});
    pause_.async_wait([this](const error_code& cancelled) {
        if (!cancelled) accept();
    });
}

bool LinkService::knows(const broker::LogId& process) const {
    const auto watch = watches_.find(process.broker);
    return watch != watches_.end() && watch->second->process() == process;
}

void LinkService::on_address(const broker::LogId& process, const Endpoint& address,
                             const Secret& secret) {
    if (address.family == Endpoint::Family::none || process.broker == self_.broker) return;
    const auto known = watches_.find(process.broker);
    if (known != watches_.end()) {
        if (known->second->process() == process) return;
        if (known->second->process().incarnation > process.incarnation) return;
        known->second->stop();
        watches_.erase(known);
    }
    if (watches_.size() == most_peers) {
        std::erase_if(watches_, [](const auto& entry) { return entry.second->is_idle(); });
        if (watches_.size() == most_peers) return;
    }
    const auto watch = std::make_shared<Watch>(*this, process, net::to_asio<tcp>(address), secret);
    watches_.emplace(process.broker, watch);
    watch->keep_up();
}

void LinkService::on_heartbeat(broker::BrokerId broker) {
    const auto known = watches_.find(broker);
    if (known != watches_.end()) known->second->keep_up();
}

}  // namespace romano::link
