// A TCP connection, with TLS or without: HTTP on it is the same. Its owner lives until the last
// operation has ended.
#pragma once

#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

namespace romano::https {

class Stream {
public:
    using Tls = boost::asio::ssl::stream<boost::beast::tcp_stream&>;
    using Role = boost::asio::ssl::stream_base::handshake_type;
    using executor_type = boost::beast::tcp_stream::executor_type;
    using error_code = boost::system::error_code;

    /// Null: without TLS.
    Stream(boost::beast::tcp_stream tcp, boost::asio::ssl::context* context)
        : tcp_(std::move(tcp)) {
        if (context != nullptr) tls_.emplace(tcp_, *context);
    }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;

    executor_type get_executor() { return tcp_.get_executor(); }
    /// Has the time limits, which hold for whole operations of TLS, too.
    [[nodiscard]] boost::beast::tcp_stream& tcp() { return tcp_; }
    /// Null without TLS.
    [[nodiscard]] Tls* tls() { return tls_ ? &*tls_ : nullptr; }

    /// Of TLS; without it there is none, and it succeeds at once. Who speaks plain HTTP to a
    /// server is told so before it fails.
    template <typename Handler>
    void async_handshake(Role role, Handler handler) {
        if (!tls_) return handler(error_code{});
        tls_->async_handshake(role, [this, handler = std::move(handler)](error_code error) mutable {
            if (!is_plain_http(error)) return handler(error);
            boost::asio::async_write(tcp_, boost::asio::buffer(answer_to_plain_http),
                                     [error, handler = std::move(handler)](
                                         error_code, std::size_t) mutable { handler(error); });
        });
    }

    template <typename Buffers, typename Handler>
    void async_read_some(const Buffers& buffers, Handler&& handler) {
        if (tls_) return (void)tls_->async_read_some(buffers, std::forward<Handler>(handler));
        tcp_.async_read_some(buffers, std::forward<Handler>(handler));
    }
    template <typename Buffers, typename Handler>
    void async_write_some(const Buffers& buffers, Handler&& handler) {
        if (tls_) return (void)tls_->async_write_some(buffers, std::forward<Handler>(handler));
        tcp_.async_write_some(buffers, std::forward<Handler>(handler));
    }

    /// Says that nothing more comes, and waits for no answer to that.
    template <typename Handler>
    void async_end(Handler handler) {
        if (tls_) {
            SSL_set_shutdown(tls_->native_handle(), SSL_RECEIVED_SHUTDOWN);
            tls_->async_shutdown(std::move(handler));
            return;
        }
        error_code error;
        tcp_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
        handler(error);
    }

private:
    static constexpr std::string_view answer_to_plain_http =
        "HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nContent-Length: 28\r\n"
        "Connection: close\r\n\r\nhere is https, and no http\r\n";

    static bool is_plain_http(const error_code& error) {
        return error.category() == boost::asio::error::get_ssl_category() &&
               ERR_GET_REASON(static_cast<unsigned long>(error.value())) == SSL_R_HTTP_REQUEST;
    }

    boost::beast::tcp_stream tcp_;
    std::optional<Tls> tls_;
};

}  // namespace romano::https
