// Who comes to an HTTP server over TCP, through its gate if there is one. Its owner lives until the
// last operation has ended.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "broker/https/gate.h"
#include "broker/https/stream.h"

namespace romano::https {

class Visitor {
public:
    using Clock = std::chrono::steady_clock;

    /// Without a gate it is plain HTTP.
    Visitor(boost::asio::ip::tcp::socket socket, std::shared_ptr<Gate> gate)
        : gate_(std::move(gate)),
          from_(address_of(socket)),
          timer_(socket.get_executor()),
          stream_(boost::beast::tcp_stream(std::move(socket)), gate_ ? &gate_->tls() : nullptr) {}

    [[nodiscard]] Stream& stream() { return stream_; }

    /// Calls `handler` when TLS is agreed upon, and at once without a gate; else never. It waits
    /// for its turn as long as `patience`, and then for the other end as long again.
    template <typename Handler>
    void enter(Clock::duration patience, Handler handler) {
        if (!gate_) return handler();
        const Clock::time_point now = Clock::now();
        if (gate_->begins_handshake(from_, now)) return shake_hands(patience, std::move(handler));
        if (!gives_up_) gives_up_ = now + patience;
        if (now >= *gives_up_) return gate_->turns_away();
        after(Gate::next_look, [this, patience, handler = std::move(handler)]() mutable {
            enter(patience, std::move(handler));
        });
    }

    /// Whether its request, which has this Authorization or none, is served.
    [[nodiscard]] bool is_let_in(std::string_view authorization) {
        return !gate_ || gate_->lets_in(authorization, from_);
    }

    /// Calls `handler` when it is time to refuse a request that is not let in: late, if it had a
    /// token and a wrong one; who has none is asked for one at once.
    template <typename Handler>
    void refuse(std::string_view authorization, Handler handler) {
        if (authorization.empty()) return handler();
        after(Gate::wait_of_a_wrong_token, std::move(handler));
    }

private:
    static Gate::Address address_of(const boost::asio::ip::tcp::socket& socket) {
        boost::system::error_code gone;
        return socket.remote_endpoint(gone).address();
    }

    template <typename Handler>
    void shake_hands(Clock::duration patience, Handler handler) {
        stream_.tcp().expires_after(patience);
        stream_.async_handshake(
            Stream::Tls::server,
            [this, handler = std::move(handler)](const boost::system::error_code& error) mutable {
                gate_->ends_handshake(from_, !error);
                if (!error) handler();
            });
    }

    template <typename Handler>
    void after(Clock::duration time, Handler handler) {
        timer_.expires_after(time);
        timer_.async_wait(
            [handler = std::move(handler)](const boost::system::error_code& stopped) mutable {
                if (!stopped) handler();
            });
    }

    std::shared_ptr<Gate> gate_;  // null: whoever comes
    Gate::Address from_;
    boost::asio::steady_timer timer_;
    std::optional<Clock::time_point> gives_up_;
    Stream stream_;
};

}  // namespace romano::https
