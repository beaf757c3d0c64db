#include "overlay/link/watch.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

#include "overlay/link/keep_alive.h"

namespace romano::link {
namespace {

using namespace std::chrono_literals;
using boost::system::error_code;

// A dying process closes its connections and its port one after the other: for a moment the port
// may still take connections, which end at once. So many attempts, at growing intervals: 40 ms.
constexpr int attempts_in_a_row = 20;
constexpr int attempts_an_interval = 4;

constexpr auto answer_within = 1s;

// A peer that was just started does not know us before it hears our beacon, and closes: it is asked
// again soon. One that never answers is asked less and less often.
constexpr auto first_rest = 10ms;
constexpr auto longest_rest = 160ms;

}  // namespace

LinkService::Watch::Watch(LinkService& service, const broker::LogId& process,
                          const boost::asio::ip::tcp::endpoint& address, const Secret& secret)
    : service_(service),
      process_(process),
      address_(address),
      secret_(secret),
      socket_(service.io_),
      timer_(service.io_),
      next_rest_(first_rest) {}

void LinkService::Watch::keep_up() {
    if (state_ == State::idle) dial();
}

void LinkService::Watch::dial() {
    state_ = State::dialling;
    ++dialled_in_a_row_;
    ++service_.counters_.dialled;
    error_code ignored;
    socket_.close(ignored);
    after(answer_within, &Watch::rest);
    socket_.async_connect(
        address_, [self = shared_from_this(), attempt = ++attempt_](const error_code& error) {
            if (!self->is_current(attempt)) return;
            if (!error) return self->greet(attempt);
            if (error == boost::asio::error::connection_refused) return self->on_refused();
            // Taken and closed before we could greet: a process may be dying.
            error == boost::asio::error::connection_reset ? self->on_closed() : self->rest();
        });
}

void LinkService::Watch::greet(std::uint64_t attempt) {
    keep_alive(socket_);
    nonce_ = sixteen_random_octets();
    outgoing_ = encode({.from = service_.self_, .to = process_, .nonce = nonce_}, secret_);
    boost::asio::async_write(socket_, boost::asio::buffer(outgoing_),
                             [self = shared_from_this()](const error_code&, std::size_t) {});
    boost::asio::async_read(
        socket_, boost::asio::buffer(incoming_),
        [self = shared_from_this(), attempt](const error_code& error, std::size_t) {
            if (!self->is_current(attempt)) return;
            error ? self->on_closed() : self->on_greeted();
        });
}

void LinkService::Watch::on_greeted() {
    const auto hello = decode(incoming_, secret_);
    const Hello expected{.from = process_, .to = service_.self_, .nonce = nonce_};
    if (hello != expected) {  // another program has the port by now
        ++service_.counters_.strangers;
        return rest();
    }
    state_ = State::up;
    was_up_ = true;
    dialled_in_a_row_ = 0;
    next_rest_ = first_rest;
    timer_.cancel();
    ++service_.counters_.up;
    // Nothing more is said on a link: whatever comes is its end.
    socket_.async_read_some(
        boost::asio::buffer(incoming_),
        [self = shared_from_this(), attempt = attempt_](const error_code&, std::size_t) {
            if (self->is_current(attempt)) self->on_closed();
        });
    service_.on_link_(process_, election::Link::up);
}

void LinkService::Watch::on_closed() {
    if (!was_up_ || dialled_in_a_row_ >= attempts_in_a_row) return rest();
    const int interval = dialled_in_a_row_ / attempts_an_interval;
    interval == 0 ? dial() : after(interval * 1ms, &Watch::dial);
}

void LinkService::Watch::on_refused() {
    const bool is_lost = was_up_;
    was_up_ = false;
    rest();
    if (!is_lost) return;
    ++service_.counters_.lost;
    service_.on_link_(process_, election::Link::lost);
}

void LinkService::Watch::rest() {
    state_ = State::resting;
    dialled_in_a_row_ = 0;
    ++attempt_;
    error_code ignored;
    socket_.close(ignored);
    after(next_rest_, &Watch::stop);
    next_rest_ = std::min(2 * next_rest_, std::chrono::milliseconds{longest_rest});
}

void LinkService::Watch::stop() {
    state_ = State::idle;
    ++attempt_;
    error_code ignored;
    timer_.cancel(ignored);
    socket_.close(ignored);
}

void LinkService::Watch::after(std::chrono::milliseconds duration, void (Watch::*what)()) {
    timer_.expires_after(duration);
    timer_.async_wait([weak = weak_from_this(), what](const error_code& cancelled) {
        if (cancelled) return;
        if (const auto self = weak.lock()) ((*self).*what)();
    });
}

}  // namespace romano::link
