// One peer's process and the connection that tells whether it lives.
#pragma once

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <memory>

#include "overlay/link/hello.h"
#include "overlay/link/link_service.h"

namespace romano::link {

class LinkService::Watch : public std::enable_shared_from_this<Watch> {
public:
    Watch(LinkService& service, const broker::LogId& process,
          const boost::asio::ip::tcp::endpoint& address, const Secret& secret);

    /// Dials unless that is under way, done, or was tried a moment ago.
    void keep_up();
    /// Says nothing any more.
    void stop();

    [[nodiscard]] const broker::LogId& process() const { return process_; }
    [[nodiscard]] bool is_idle() const { return state_ == State::idle; }

private:
    enum class State : std::uint8_t { idle, dialling, up, resting };

    void dial();
    void greet(std::uint64_t attempt);
    void on_greeted();
    void on_closed();
    void on_refused();
    void rest();
    void after(std::chrono::milliseconds duration, void (Watch::*what)());
    /// Whether a handler still speaks of this connection.
    [[nodiscard]] bool is_current(std::uint64_t attempt) const { return attempt == attempt_; }

    LinkService& service_;
    broker::LogId process_;
    boost::asio::ip::tcp::endpoint address_;
    Secret secret_;  // of the process
    Nonce nonce_{};  // of this attempt
    boost::asio::ip::tcp::socket socket_;
    boost::asio::steady_timer timer_;
    std::chrono::milliseconds next_rest_;  // after an attempt that failed
    State state_ = State::idle;
    bool was_up_ = false;        // and its loss was not told
    int dialled_in_a_row_ = 0;   // since it was up, or had a rest
    std::uint64_t attempt_ = 0;  // numbers the connections
    std::array<std::uint8_t, Hello::octets> incoming_{};
    std::array<std::uint8_t, Hello::octets> outgoing_{};
};

}  // namespace romano::link
