// Takes TCP connections at an address, for as long as it lives. When the process has no file
// descriptor left, those that come wait, and it tries again each second.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/error_code.hpp>
#include <functional>

#include "romano/base/endpoint.h"

namespace romano::net {

class TcpAcceptor {
public:
    using OnConnection = std::function<void(boost::asio::ip::tcp::socket)>;

    TcpAcceptor(boost::asio::io_context& io, OnConnection on_connection);

    /// So many connections may wait until they are taken.
    [[nodiscard]] boost::system::error_code open(const Endpoint& address, std::size_t most_waiting);
    /// With the port that was chosen for port 0. None before open().
    [[nodiscard]] Endpoint address() const { return address_; }

private:
    void accept();

    OnConnection on_connection_;
    boost::asio::ip::tcp::acceptor acceptor_;
    boost::asio::steady_timer pause_;
    Endpoint address_;
};

}  // namespace romano::net
