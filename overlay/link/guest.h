// A connection that somebody made to us: says who we are to a peer that we know, and is held until
// it ends. Nobody else is answered.
#pragma once

#include <array>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <optional>

#include "broker/core/log_position.h"
#include "overlay/link/hello.h"
#include "overlay/link/link_service.h"

namespace romano::link {

class LinkService::Guest : public std::enable_shared_from_this<Guest> {
public:
    Guest(LinkService& service, boost::asio::ip::tcp::socket socket);

    void receive();
    void stop();

private:
    void on_hello();
    void replace_earlier_one();
    void hold();
    void leave();

    LinkService* service_;  // null once stopped
    boost::asio::ip::tcp::socket socket_;
    boost::asio::steady_timer timer_;
    std::optional<broker::BrokerId> peer_;  // once it has said its Hello
    std::array<std::uint8_t, Hello::octets> incoming_{};
    std::array<std::uint8_t, Hello::octets> outgoing_{};
};

}  // namespace romano::link
