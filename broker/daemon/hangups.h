// SIGHUP: the broker's rights may have changed, as daemons are told of their files.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <functional>
#include <utility>

namespace romano::daemon {

class Hangups {
public:
    Hangups(boost::asio::io_context& io, std::function<void()> on_hangup)
        : signals_(io, SIGHUP), on_hangup_(std::move(on_hangup)) {
        wait();
    }

private:
    void wait() {
        signals_.async_wait([this](const auto& error, int) {
            if (error) return;
            on_hangup_();
            wait();
        });
    }

    boost::asio::signal_set signals_;
    std::function<void()> on_hangup_;
};

}  // namespace romano::daemon
