#include "overlay/link/guest.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <utility>

#include "overlay/link/keep_alive.h"

namespace romano::link {
namespace {

constexpr auto hello_within = std::chrono::seconds{1};

}  // namespace

using boost::system::error_code;

LinkService::Guest::Guest(LinkService& service, boost::asio::ip::tcp::socket socket)
    : service_(&service), socket_(std::move(socket)), timer_(service.io_) {
    keep_alive(socket_);
}

void LinkService::Guest::receive() {
    timer_.expires_after(hello_within);
    timer_.async_wait([weak = weak_from_this()](const error_code& cancelled) {
        const auto self = weak.lock();
        if (cancelled || !self || self->service_ == nullptr) return;
        ++self->service_->counters_.strangers;
        self->leave();
    });
    boost::asio::async_read(socket_, boost::asio::buffer(incoming_),
                            [self = shared_from_this()](const error_code& error, std::size_t) {
                                if (self->service_ == nullptr) return;
                                self->timer_.cancel();
                                if (!error) return self->on_hello();
                                ++self->service_->counters_.strangers;
                                self->leave();
                            });
}

void LinkService::Guest::on_hello() {
    const auto hello = decode(incoming_, service_->secret_);
    if (!hello || hello->to != service_->self_ || !service_->knows(hello->from)) {
        ++service_->counters_.strangers;
        return leave();
    }
    peer_ = hello->from.broker;
    replace_earlier_one();
    outgoing_ = encode({.from = service_->self_, .to = hello->from, .nonce = hello->nonce},
                       service_->secret_);
    boost::asio::async_write(socket_, boost::asio::buffer(outgoing_),
                             [self = shared_from_this()](const error_code& error, std::size_t) {
                                 if (self->service_ == nullptr) return;
                                 error ? self->leave() : self->hold();
                             });
}

/// A peer has one connection to us. What it had before may never end: who lost its power, or was
/// cut off meanwhile, closes nothing.
void LinkService::Guest::replace_earlier_one() {
    std::erase_if(service_->guests_, [this](const auto& guest) {
        if (guest.get() == this || guest->peer_ != peer_) return false;
        guest->stop();
        return true;
    });
}

void LinkService::Guest::hold() {
    socket_.async_read_some(boost::asio::buffer(incoming_),
                            [self = shared_from_this()](const error_code& error, std::size_t) {
                                if (self->service_ == nullptr) return;
                                if (!error) ++self->service_->counters_.strangers;  // it babbles
                                self->leave();
                            });
}

void LinkService::Guest::leave() {
    const auto self = shared_from_this();
    LinkService* service = std::exchange(service_, nullptr);
    stop();
    service->guests_.erase(self);
}

void LinkService::Guest::stop() {
    service_ = nullptr;
    error_code ignored;
    timer_.cancel(ignored);
    socket_.close(ignored);
}

}  // namespace romano::link
