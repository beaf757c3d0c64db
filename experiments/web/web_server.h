// HTTP/1.1 for the API and the page, and Server-Sent Events: what has changed in the picture, ten
// times a second at most. Behind a gate it is HTTPS, and each request shows the token.
//
// Bounded against bad clients: so many connections and streams at a time, small requests, seconds
// to ask and to read. Who reads a stream slowly gets fewer and larger changes; nothing piles up.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstddef>
#include <memory>

#include "broker/https/gate.h"
#include "broker/net/tcp_acceptor.h"
#include "experiments/fleet/fleet_picture.h"
#include "experiments/web/web_api.h"

namespace romano::experiments {

class WebServer {
public:
    static constexpr std::size_t most_connections = 128;
    static constexpr std::size_t most_streams = 64;
    static constexpr std::chrono::seconds patience{10};
    static constexpr std::chrono::milliseconds stream_every{100};

    /// Without a gate it is plain HTTP for whoever comes.
    WebServer(boost::asio::io_context& io, const FleetPicture& picture, WebApi& api,
              std::shared_ptr<https::Gate> gate = nullptr);
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    [[nodiscard]] boost::system::error_code open(const Endpoint& address) {
        return acceptor_.open(address, most_connections);
    }
    /// With the port that was chosen for port 0.
    [[nodiscard]] Endpoint address() const { return acceptor_.address(); }

private:
    class Connection;
    struct OpenOnes {  // a connection may outlive the server
        std::size_t connections = 0;
        std::size_t streams = 0;
    };

    void on_connection(boost::asio::ip::tcp::socket socket);

    const FleetPicture& picture_;
    WebApi& api_;
    std::shared_ptr<https::Gate> gate_;
    net::TcpAcceptor acceptor_;
    std::shared_ptr<OpenOnes> open_;
};

}  // namespace romano::experiments
