#include "broker/metrics/http_server.h"

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <string_view>
#include <utility>

#include "broker/https/visitor.h"

namespace romano::metrics {
namespace {

namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::asio::ip::tcp;

constexpr std::size_t most_header_octets = 4096;

}  // namespace

/// One request and its answer. Lives as long as an operation on its socket is pending.
class HttpServer::Connection : public std::enable_shared_from_this<Connection> {
public:
    Connection(HttpServer& server, tcp::socket socket)
        : server_(server),
          open_(server.open_connections_),
          visitor_(std::move(socket), server.gate_) {
        ++*open_;
        parser_.header_limit(most_header_octets);
        parser_.body_limit(0);
    }
    ~Connection() { --*open_; }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    void begin() {
        visitor_.enter(patience, [self = shared_from_this()] { self->read(); });
    }

private:
    void read() {
        visitor_.stream().tcp().expires_after(patience);
        http::async_read(visitor_.stream(), buffer_, parser_,
                         [self = shared_from_this()](beast::error_code error, std::size_t) {
                             self->on_read(error);
                         });
    }

    void on_read(const beast::error_code& error) {
        if (!error) {
            answer(parser_.get());
        } else if (error.category() == http::make_error_code(http::error::bad_method).category() &&
                   error != http::error::end_of_stream) {
            respond(http::status::bad_request, "no HTTP request that is served here\n");
        }  // else: gone, or too slow
    }

    void answer(const http::request<http::empty_body>& request) {
        is_head_ = request.method() == http::verb::head;
        const auto field = request[http::field::authorization];
        const std::string_view shown{field.data(), field.size()};
        if (!visitor_.is_let_in(shown)) return refuse(shown);
        if (!is_head_ && request.method() != http::verb::get) {
            respond(http::status::method_not_allowed, "GET /metrics\n");
        } else if (request.target() == "/metrics" || request.target().starts_with("/metrics?")) {
            respond(http::status::ok, server_.page());
        } else {
            respond(http::status::not_found, "GET /metrics\n");
        }
    }

    void refuse(std::string_view shown) {
        response_.set(http::field::www_authenticate, https::Token::challenge);
        visitor_.refuse(shown, [self = shared_from_this()] {
            self->respond(http::status::unauthorized, "a token is needed\n");
        });
    }

    void respond(http::status status, const std::string& body) {
        response_.version(11);
        response_.result(status);
        response_.keep_alive(false);
        response_.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
        response_.content_length(body.size());
        if (!is_head_) response_.body() = body;
        visitor_.stream().tcp().expires_after(patience);
        http::async_write(visitor_.stream(), response_,
                          [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                              if (!error)
                                  self->visitor_.stream().async_end([self](beast::error_code) {});
                          });
    }

    HttpServer& server_;
    std::shared_ptr<std::size_t> open_;
    https::Visitor visitor_;
    beast::flat_static_buffer<2 * most_header_octets> buffer_;
    http::request_parser<http::empty_body> parser_;
    http::response<http::string_body> response_;
    bool is_head_ = false;
};

HttpServer::HttpServer(boost::asio::io_context& io, std::function<std::string()> make_page,
                       std::shared_ptr<https::Gate> gate)
    : make_page_(std::move(make_page)),
      gate_(std::move(gate)),
      acceptor_(io, [this](tcp::socket socket) { on_connection(std::move(socket)); }),
      open_connections_(std::make_shared<std::size_t>(0)) {}

void HttpServer::on_connection(tcp::socket socket) {
    if (*open_connections_ >= most_connections) return;
    std::make_shared<Connection>(*this, std::move(socket))->begin();
}

const std::string& HttpServer::page() {
    const auto now = std::chrono::steady_clock::now();
    if (now >= page_until_) {
        page_ = make_page_();
        page_until_ = now + page_lives;
    }
    return page_;
}

}  // namespace romano::metrics
