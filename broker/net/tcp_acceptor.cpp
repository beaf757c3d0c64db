#include "broker/net/tcp_acceptor.h"

#include <chrono>
#include <utility>

#include "broker/net/asio_endpoint.h"

namespace romano::net {

using boost::asio::ip::tcp;
using boost::system::error_code;

TcpAcceptor::TcpAcceptor(boost::asio::io_context& io, OnConnection on_connection)
    : on_connection_(std::move(on_connection)), acceptor_(io), pause_(io) {}

error_code TcpAcceptor::open(const Endpoint& address, std::size_t most_waiting) {
    tcp::endpoint at = to_asio<tcp>(address);
    error_code error;
    acceptor_.open(at.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(at, error);
    if (!error) acceptor_.listen(static_cast<int>(most_waiting), error);
    if (!error) at = acceptor_.local_endpoint(error);
    if (error) return error;
    address_ = address;
    address_.port = at.port();
    accept();
    return {};
}

void TcpAcceptor::accept() {
    acceptor_.async_accept([this](const error_code& error, tcp::socket socket) {
        if (error == boost::asio::error::operation_aborted) return;
        if (!error) {
            on_connection_(std::move(socket));
            return accept();
        }
        pause_.expires_after(std::chrono::seconds{1});
        pause_.async_wait([this](const error_code& stopped) {
            if (!stopped) accept();
        });
    });
}

}  // namespace romano::net
