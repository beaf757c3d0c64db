#include "experiments/watch/metrics_fetch.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/error.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <stdexcept>

#include "broker/https/stream.h"
#include "broker/https/tls.h"
#include "broker/https/token.h"

namespace romano::experiments {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using boost::asio::ip::tcp;
using boost::system::error_code;

/// One request over a stream, and what came of it.
class Fetch {
public:
    Fetch(boost::asio::io_context& io, const MetricsAddress& address,
          boost::asio::ssl::context* tls)
        : stream_(beast::tcp_stream(io), tls) {
        request_.set(http::field::host, address.host);
        if (address.token) {
            request_.set(http::field::authorization, https::Token(*address.token).authorization());
        }
        parser_.body_limit(16U << 20U);
        if (tls == nullptr) return;
        std::string name = address.name.value_or(address.host);
        stream_.tls()->set_verify_callback(boost::asio::ssl::host_name_verification(name));
        error_code is_no_address;
        (void)boost::asio::ip::make_address(name, is_no_address);
        if (!is_no_address) return;
        SSL_ctrl(stream_.tls()->native_handle(), SSL_CTRL_SET_TLSEXT_HOSTNAME,
                 TLSEXT_NAMETYPE_host_name, name.data());
    }

    void start(const tcp::resolver::results_type& found, std::chrono::milliseconds patience) {
        stream_.tcp().expires_after(patience);
        stream_.tcp().async_connect(found, [this](const error_code& error, const auto&) {
            failed_ = error;
            if (!error) shake_hands();
        });
    }

    [[nodiscard]] const error_code& failed() const { return failed_; }
    [[nodiscard]] const http::response<http::string_body>& answer() const { return parser_.get(); }

private:
    void shake_hands() {
        stream_.async_handshake(https::Stream::Tls::client, [this](const error_code& error) {
            failed_ = error;
            if (!error) ask();
        });
    }
    void ask() {
        http::async_write(stream_, request_, [this](const error_code& unwritten, std::size_t) {
            failed_ = unwritten;
            if (failed_) return;
            http::async_read(stream_, buffer_, parser_,
                             [this](const error_code& unread, std::size_t) { failed_ = unread; });
        });
    }

    https::Stream stream_;
    http::request<http::empty_body> request_{http::verb::get, "/metrics", 11};
    beast::flat_buffer buffer_;
    http::response_parser<http::string_body> parser_;
    error_code failed_;
};

std::string advice(const MetricsAddress& address, const error_code& failed) {
    if (failed.category() == boost::asio::error::get_ssl_category()) {
        return "; --ca names the certificate of whoever vouches for the broker's, --name the name "
               "in that";
    }
    return "; start the broker with --metrics " + address.host + ":" + address.port;
}

}  // namespace

std::optional<MetricsAddress> parse_metrics_address(std::string_view text) {
    constexpr std::string_view scheme = "https://";
    MetricsAddress out{.host = {}, .port = {}};
    if (text.starts_with(scheme)) {
        out.is_https = true;
        text.remove_prefix(scheme.size());
    }
    const auto colon = text.rfind(':');
    if (colon == std::string_view::npos || colon == 0 || colon + 1 == text.size()) return {};
    out.port = text.substr(colon + 1);
    out.host = text.substr(0, colon);
    if (out.host.starts_with('[') && out.host.ends_with(']')) {
        out.host = out.host.substr(1, out.host.size() - 2);
    }
    return out;
}

std::string fetch_metrics(const MetricsAddress& address, std::chrono::milliseconds patience) {
    const std::string where = std::string{address.is_https ? "https" : "http"} + "://" +
                              address.host + ":" + address.port + "/metrics";
    boost::asio::io_context io{1};
    error_code failed;
    tcp::resolver resolver(io);
    const auto found = resolver.resolve(address.host, address.port, failed);
    if (failed) throw std::runtime_error("cannot find the host `" + address.host + "`");

    std::optional<boost::asio::ssl::context> tls;
    if (address.is_https) tls.emplace(https::client_tls(address.authority));
    Fetch fetch(io, address, tls ? &*tls : nullptr);
    fetch.start(found, patience);
    io.run();
    failed = fetch.failed();
    if (failed) {
        throw std::runtime_error("no metrics at " + where + ": " + failed.message() +
                                 advice(address, failed));
    }
    const auto status = fetch.answer().result_int();
    if (status == 401) {
        throw std::runtime_error("no metrics at " + where +
                                 ": the broker wants its token; give the file with --token");
    }
    if (status != 200) {
        throw std::runtime_error("no metrics at " + where + ": the answer is " +
                                 std::to_string(status));
    }
    return fetch.answer().body();
}

}  // namespace romano::experiments
