#include "experiments/web/web_server.h"

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "broker/https/visitor.h"
#include "experiments/fleet/picture_json.h"

namespace romano::experiments {
namespace {

namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::asio::ip::tcp;
using nlohmann::ordered_json;

constexpr std::size_t most_header_octets = 16UL * 1024;
constexpr std::size_t most_body_octets = 4UL * 1024;

/// Nothing from elsewhere, in no frame of another page, and no text becomes a script.
constexpr const char* content_security_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

template <typename Body>
void set_headers(http::response<Body>& response, const WebAnswer& answer) {
    response.set(http::field::content_type, answer.content_type);
    response.set(http::field::cache_control, "no-store");
    response.set("Content-Security-Policy", content_security_policy);
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    if (!answer.allow.empty()) response.set(http::field::allow, answer.allow);
    if (answer.status == 401) response.set(http::field::www_authenticate, https::Token::challenge);
}

std::string event(const char* name, const ordered_json& data) {
    return std::string{"event: "} + name +
           "\ndata: " + data.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n\n";
}

}  // namespace

/// One browser's connection: request after request, or a stream of events to its end. Lives as long
/// as an operation on its socket or its timer is pending.
class WebServer::Connection : public std::enable_shared_from_this<Connection> {
public:
    Connection(WebServer& server, tcp::socket socket)
        : picture_(server.picture_),
          api_(server.api_),
          open_(server.open_),
          timer_(socket.get_executor()),
          visitor_(std::move(socket), server.gate_) {
        ++open_->connections;
    }
    ~Connection() {
        --open_->connections;
        if (is_stream_) --open_->streams;
    }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    void begin() {
        visitor_.enter(patience, [self = shared_from_this()] { self->read(); });
    }

private:
    void read() {
        parser_.emplace();
        parser_->header_limit(most_header_octets);
        parser_->body_limit(most_body_octets);
        visitor_.stream().tcp().expires_after(patience);
        http::async_read(visitor_.stream(), buffer_, *parser_,
                         [self = shared_from_this()](beast::error_code error, std::size_t) {
                             self->on_read(error);
                         });
    }

    void on_read(const beast::error_code& error) {
        if (!error) return answer(parser_->get());
        if (error == http::error::body_limit || error == http::error::header_limit) {
            return respond({.status = 413, .content_type = "text/plain", .body = "too long\n"},
                           false, false);
        }
        const bool is_no_http =
            error.category() == http::make_error_code(http::error::bad_method).category();
        if (is_no_http && error != http::error::end_of_stream &&
            error != http::error::partial_message) {
            respond({.status = 400, .content_type = "text/plain", .body = "no HTTP request\n"},
                    false, false);
        }  // else: gone, or too slow
    }

    void answer(const http::request<http::string_body>& request) {
        const auto text = [](beast::string_view view) {
            return std::string{view.data(), view.size()};
        };
        const bool is_head = request.method() == http::verb::head;
        const std::string shown = text(request[http::field::authorization]);
        if (!visitor_.is_let_in(shown)) return refuse(shown, is_head);
        WebAnswer answer =
            api_.answer({.method = text(request.method_string()),
                         .target = text(request.target()),
                         .fields = {.host = text(request[http::field::host]),
                                    .origin = text(request[http::field::origin]),
                                    .fetch_site = text(request["Sec-Fetch-Site"]),
                                    .content_type = text(request[http::field::content_type])},
                         .body = request.body()});
        if (!answer.is_event_stream) return respond(answer, request.keep_alive(), is_head);
        if (open_->streams >= most_streams) {
            return respond({.status = 503,
                            .content_type = "application/json",
                            .body = "{\"error\": \"too many look at this already\"}\n"},
                           request.keep_alive(), is_head);
        }
        begin_stream(answer);
    }

    void refuse(const std::string& shown, bool is_head) {
        visitor_.refuse(shown, [self = shared_from_this(), is_head] {
            self->respond({.status = 401,
                           .content_type = "application/json",
                           .body = "{\"error\": \"a token is needed\"}\n"},
                          false, is_head);
        });
    }

    void respond(const WebAnswer& answer, bool keep_alive, bool is_head) {
        response_ = {};
        response_.version(11);
        response_.result(answer.status);
        response_.keep_alive(keep_alive);
        set_headers(response_, answer);
        response_.content_length(answer.body.size());
        if (!is_head) response_.body() = answer.body;
        visitor_.stream().tcp().expires_after(patience);
        http::async_write(
            visitor_.stream(), response_,
            [self = shared_from_this(), keep_alive](beast::error_code error, std::size_t) {
                if (error) return;
                if (keep_alive) return self->read();
                self->visitor_.stream().async_end([self](beast::error_code) {});
            });
    }

    void begin_stream(const WebAnswer& answer) {
        is_stream_ = true;
        ++open_->streams;
        head_.version(11);
        head_.result(http::status::ok);
        head_.keep_alive(false);
        set_headers(head_, answer);
        head_serializer_.emplace(head_);
        visitor_.stream().tcp().expires_after(patience);
        http::async_write_header(
            visitor_.stream(), *head_serializer_,
            [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                if (error) return;
                self->visitor_.stream().tcp().expires_never();  // each sending has its own limit
                self->watch_for_end();
                self->send_whole();
            });
    }

    /// Who leaves a stream is known by the end of what it sends; what else comes is not read.
    void watch_for_end() {
        visitor_.stream().async_read_some(
            boost::asio::buffer(room_),
            [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                if (error) return self->close();
                self->watch_for_end();
            });
    }

    void close() {
        timer_.cancel();
        visitor_.stream().tcp().close();
    }

    void send_whole() {
        sent_version_ = picture_.version();
        send(event("state", to_json(picture_)));
    }

    void send_changes() {
        if (picture_.version() == sent_version_) return wait();
        const auto changes = changes_since(picture_, sent_version_);
        if (!changes) return send_whole();
        sent_version_ = picture_.version();
        send(event("change", *changes));
    }

    void send(std::string text) {
        text_ = std::move(text);
        visitor_.stream().tcp().expires_after(patience);
        boost::asio::async_write(
            visitor_.stream(), boost::asio::buffer(text_),
            [self = shared_from_this()](const beast::error_code& error, std::size_t) {
                if (!error) self->wait();
            });
    }

    void wait() {
        visitor_.stream().tcp().expires_never();
        timer_.expires_after(stream_every);
        timer_.async_wait([self = shared_from_this()](const beast::error_code& stopped) {
            if (!stopped && self->visitor_.stream().tcp().socket().is_open()) self->send_changes();
        });
    }

    const FleetPicture& picture_;
    WebApi& api_;
    std::shared_ptr<OpenOnes> open_;
    boost::asio::steady_timer timer_;
    https::Visitor visitor_;
    beast::flat_static_buffer<most_header_octets + most_body_octets> buffer_;
    std::optional<http::request_parser<http::string_body>> parser_;
    http::response<http::string_body> response_;

    bool is_stream_ = false;
    http::response<http::empty_body> head_;
    std::optional<http::response_serializer<http::empty_body>> head_serializer_;
    std::uint64_t sent_version_ = 0;
    std::string text_;
    std::array<char, 512> room_{};  // for what nobody reads
};

WebServer::WebServer(boost::asio::io_context& io, const FleetPicture& picture, WebApi& api,
                     std::shared_ptr<https::Gate> gate)
    : picture_(picture),
      api_(api),
      gate_(std::move(gate)),
      acceptor_(io, [this](tcp::socket socket) { on_connection(std::move(socket)); }),
      open_(std::make_shared<OpenOnes>()) {}

void WebServer::on_connection(tcp::socket socket) {
    if (open_->connections >= most_connections) return;
    std::make_shared<Connection>(*this, std::move(socket))->begin();
}

}  // namespace romano::experiments
