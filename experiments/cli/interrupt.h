// Ctrl-C or SIGTERM, for a command that turns its own loop: it says goodbye to the broker, which
// else would keep its session until the keep-alive ends.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>

namespace romano::experiments {

class Interrupt {
public:
    explicit Interrupt(boost::asio::io_context& io) : signals_(io, SIGINT, SIGTERM) {
        signals_.async_wait([this](const auto& stopped, int) { has_come_ = !stopped; });
    }
    [[nodiscard]] bool has_come() const { return has_come_; }

private:
    boost::asio::signal_set signals_;
    bool has_come_ = false;
};

}  // namespace romano::experiments
