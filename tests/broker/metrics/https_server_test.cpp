// The page behind a gate, and clients that are none. What well-kept clients see: tests/system.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <string>
#include <vector>

#include "broker/https/stream.h"
#include "broker/https/tls.h"
#include "broker/metrics/http_server.h"
#include "broker/net/endpoint_text.h"
#include "tests/https_files.h"

namespace romano::metrics::https_server_test {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using boost::system::error_code;
using testing::HasSubstr;
using testing::StartsWith;

struct PageBehindAGate : testing::Test {
    PageBehindAGate() { EXPECT_FALSE(server.open(*net::parse_endpoint("127.0.0.1:0"))); }

    /// Says what it is told to say, as it is or through TLS, and listens to the end.
    struct Client : std::enable_shared_from_this<Client> {
        Client(boost::asio::io_context& io, std::uint16_t port, boost::asio::ssl::context* tls,
               const char* from = "127.0.0.1")
            : stream(boost::beast::tcp_stream(io), tls) {
            stream.tcp().socket().open(tcp::v4());
            stream.tcp().socket().bind({boost::asio::ip::make_address(from), 0});
            stream.tcp().connect({boost::asio::ip::address_v4::loopback(), port});
        }
        void say(const std::string& text) {
            stream.async_handshake(https::Stream::Tls::client,
                                   [self = shared_from_this(), text](const error_code& error) {
                                       if (error) return self->end();
                                       self->said = text;
                                       self->send();
                                   });
        }
        void send() {
            boost::asio::async_write(stream, boost::asio::buffer(said),
                                     [self = shared_from_this()](const auto&, std::size_t) {});
            listen();
        }
        void listen() {
            boost::asio::async_read(
                stream, boost::asio::dynamic_buffer(heard),
                [self = shared_from_this()](const auto&, std::size_t) { self->end(); });
        }
        void end() {
            closed = true;
            stream.tcp().close();
        }
        https::Stream stream;
        std::string said;
        std::string heard;
        bool closed = false;
    };

    std::shared_ptr<Client> client(boost::asio::ssl::context* with) {
        return std::make_shared<Client>(io, server.address().port, with);
    }
    std::string answer_to(const std::string& request, boost::asio::ssl::context* with) {
        const auto asking = client(with);
        asking->say(request);
        runs_until([&] { return asking->closed; });
        return asking->heard;
    }
    static std::string get(const std::string& authorization) {
        return "GET /metrics HTTP/1.1\r\nHost: r1\r\n" + authorization + "\r\n";
    }
    static std::string wrong_token() {
        return get("Authorization: Bearer an0ther-word_of.24~charz\r\n");
    }
    static std::string with_the_token() {
        return get(std::string{"Authorization: Bearer "} + tests::HttpsFiles::word + "\r\n");
    }
    template <typename Done>
    void runs_until(Done&& done, std::chrono::seconds limit = 30s) {
        const auto deadline = std::chrono::steady_clock::now() + limit;
        while (!done() && std::chrono::steady_clock::now() < deadline) io.run_one_for(50ms);
        EXPECT_TRUE(done());
    }

    boost::asio::io_context io;
    tests::HttpsFiles files;
    boost::asio::ssl::context tls = https::client_tls(files.authority());
    std::shared_ptr<https::Gate> gate =
        std::make_shared<https::Gate>(https::GateFiles{files.certificate(), files.token()});
    int pages = 0;
    HttpServer server{io,
                      [this] {
                          ++pages;
                          return std::string("romano_test 1\n");
                      },
                      gate};
};

TEST_F(PageBehindAGate, IsServedToWhomHasTheToken) {
    const std::string answer = answer_to(with_the_token(), &tls);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK\r\n"));
    EXPECT_THAT(answer, testing::EndsWith("\r\n\r\nromano_test 1\n"));
}

TEST_F(PageBehindAGate, AnswersAWrongTokenLateAndAMissingOneAtOnce) {
    const auto began = std::chrono::steady_clock::now();
    const auto wrong = client(&tls);
    wrong->say(wrong_token());
    EXPECT_THAT(answer_to(get(""), &tls), StartsWith("HTTP/1.1 401 "));
    EXPECT_FALSE(wrong->closed);
    runs_until([&] { return wrong->closed; });
    EXPECT_GE(std::chrono::steady_clock::now() - began, https::Gate::wait_of_a_wrong_token);
    EXPECT_THAT(wrong->heard, StartsWith("HTTP/1.1 401 "));
    EXPECT_THAT(wrong->heard, HasSubstr("WWW-Authenticate: Basic "));
    EXPECT_EQ(pages, 0);
    EXPECT_EQ(gate->counts().wrong_tokens, 1U);
    EXPECT_EQ(gate->counts().without_token, 1U);
}

TEST_F(PageBehindAGate, ServesOthersWhileAWrongTokenWaits) {
    const auto wrong = client(&tls);
    wrong->say(wrong_token());
    runs_until([&] { return gate->counts().wrong_tokens == 1; });
    const auto right = client(&tls);
    right->say(with_the_token());
    runs_until([&] { return right->closed; });
    EXPECT_FALSE(wrong->closed);
    EXPECT_THAT(right->heard, HasSubstr(" 200 "));
    runs_until([&] { return wrong->closed; });
}

TEST_F(PageBehindAGate, TellsWhoSpeaksPlainHttpWhatIsSpokenHere) {
    const std::string answer = answer_to(with_the_token(), nullptr);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 400 "));
    EXPECT_THAT(answer, testing::EndsWith("here is https, and no http\r\n"));
    EXPECT_EQ(pages, 0);
}

TEST_F(PageBehindAGate, ClosesOnGarbageInPlaceOfAClientHello) {
    EXPECT_THAT(answer_to(std::string("\x00\x01\x02\x7F garbage\r\n\r\n", 15), nullptr),
                testing::Not(HasSubstr("HTTP")));
    const std::string record("\x16\x03\x01\xFF\xFF\x01", 6);  // a ClientHello of 64 KiB
    (void)answer_to(record + std::string(70'000, 'x'), nullptr);
    runs_until([&] { return gate->counts().handshakes_failed == 2; });
    EXPECT_THAT(answer_to(with_the_token(), &tls), HasSubstr(" 200 "));
}

TEST_F(PageBehindAGate, WhoIsSilentInTheHandshakeKeepsNoOtherAddressOutAndNobodyForLong) {
    std::vector<std::shared_ptr<Client>> silent;
    for (std::size_t i = 0; i < https::Gate::most_handshakes / 2; ++i) {
        silent.push_back(client(nullptr));
        silent.back()->listen();
    }
    const auto other = std::make_shared<Client>(io, server.address().port, &tls, "127.0.0.2");
    other->say(with_the_token());
    runs_until([&] { return other->closed; });
    EXPECT_THAT(other->heard, HasSubstr(" 200 "));
    EXPECT_FALSE(silent.front()->closed);
    runs_until([&] { return silent.front()->closed && silent.back()->closed; });
    EXPECT_EQ(gate->counts().handshakes_failed, silent.size());
    EXPECT_THAT(answer_to(with_the_token(), &tls), HasSubstr(" 200 "));
}

TEST_F(PageBehindAGate, WhoGoesAwayInTheMiddleLeavesNothingBehind) {
    for (int n = 0; n < 10; ++n) {
        const auto gone = client(nullptr);
        boost::asio::write(gone->stream.tcp().socket(),
                           boost::asio::buffer(std::string("\x16\x03\x01\x01\x00", 5)));
        gone->stream.tcp().close();
    }
    runs_until([&] { return gate->counts().handshakes_failed == 10; });
    EXPECT_THAT(answer_to(with_the_token(), &tls), HasSubstr(" 200 "));
}

TEST_F(PageBehindAGate, AgreesOnNothingOlderThanTls12) {
    boost::asio::ssl::context old(boost::asio::ssl::context::tls_client);
    SSL_CTX_set_security_level(old.native_handle(), 0);
    SSL_CTX_set_max_proto_version(old.native_handle(), TLS1_1_VERSION);
    EXPECT_EQ(answer_to(with_the_token(), &old), "");
    EXPECT_EQ(pages, 0);
}

}  // namespace
}  // namespace romano::metrics::https_server_test
