// HTTP/1.1 for the API and the page, and Server-Sent Events: what has changed in the picture, ten
// times a second at most.
//
// Bounded against bad clients: so many connections and streams at a time, small requests, seconds
// to ask and to read. Who reads a stream slowly gets fewer and larger changes; nothing piles up.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstddef>
#include <memory>

#include "experiments/fleet/fleet_picture.h"
#include "experiments/web/web_api.h"

namespace romano::experiments {

class WebServer {
public:
    static constexpr std::size_t most_connections = 128;
    static constexpr std::size_t most_streams = 64;
    static constexpr std::chrono::seconds patience{10};
    static constexpr std::chrono::milliseconds stream_every{100};

    WebServer(boost::asio::io_context& io, const FleetPicture& picture, WebApi& api);
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    [[nodiscard]] boost::system::error_code open(const boost::asio::ip::tcp::endpoint& address);
    /// With the port that was chosen for port 0.
    [[nodiscard]] boost::asio::ip::tcp::endpoint address() const;

private:
    class Connection;
    struct OpenOnes {  // a connection may outlive the server
        std::size_t connections = 0;
        std::size_t streams = 0;
    };

    void accept();

    const FleetPicture& picture_;
    WebApi& api_;
    boost::asio::ip::tcp::acceptor acceptor_;
    boost::asio::steady_timer pause_;
    std::shared_ptr<OpenOnes> open_;
};

}  // namespace romano::experiments
