// GET /metrics over HTTP, on the broker's own io_context; behind a gate over HTTPS.
//
// Bounded against bad clients: so many connections at a time (further ones are closed at once), one
// request each with a small header, five seconds for a handshake, to ask and to read, and a page
// that is made anew at most ten times a second.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "broker/https/gate.h"
#include "broker/net/tcp_acceptor.h"
#include "romano/base/endpoint.h"

namespace romano::metrics {

class HttpServer {
public:
    static constexpr std::size_t most_connections = 16;
    static constexpr std::chrono::seconds patience{5};
    static constexpr std::chrono::milliseconds page_lives{100};

    /// Without a gate it is plain HTTP for whoever comes.
    HttpServer(boost::asio::io_context& io, std::function<std::string()> make_page,
               std::shared_ptr<https::Gate> gate = nullptr);
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    [[nodiscard]] boost::system::error_code open(const Endpoint& address) {
        return acceptor_.open(address, most_connections);
    }
    /// With the port that was chosen for port 0.
    [[nodiscard]] Endpoint address() const { return acceptor_.address(); }

private:
    class Connection;

    void on_connection(boost::asio::ip::tcp::socket socket);
    const std::string& page();

    std::function<std::string()> make_page_;
    std::shared_ptr<https::Gate> gate_;
    net::TcpAcceptor acceptor_;
    std::shared_ptr<std::size_t> open_connections_;  // a connection may outlive this
    std::string page_;
    std::chrono::steady_clock::time_point page_until_{};
};

}  // namespace romano::metrics
