// The page over HTTP, and clients that are none.

#include "broker/metrics/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <string>
#include <vector>

#include "broker/net/endpoint_text.h"

namespace romano::metrics::http_server_test {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using testing::HasSubstr;
using testing::StartsWith;

struct HttpServerTest : testing::Test {
    HttpServerTest() { EXPECT_FALSE(server.open(*net::parse_endpoint("127.0.0.1:0"))); }

    struct Client {
        explicit Client(boost::asio::io_context& io) : socket(io) {}
        tcp::socket socket;
        std::string heard;
        bool closed = false;
    };

    std::shared_ptr<Client> client() {
        auto made = std::make_shared<Client>(io);
        made->socket.connect({boost::asio::ip::address_v4::loopback(), server.address().port});
        boost::asio::async_read(made->socket, boost::asio::dynamic_buffer(made->heard),
                                [made](const auto&, std::size_t) { made->closed = true; });
        return made;
    }

    std::string answer_to(const std::string& request) {
        auto asking = client();
        boost::asio::write(asking->socket, boost::asio::buffer(request));
        runs_until([&] { return asking->closed; });
        return asking->heard;
    }

    template <typename Done>
    void runs_until(Done&& done, std::chrono::seconds limit = 20s) {
        const auto deadline = std::chrono::steady_clock::now() + limit;
        while (!done() && std::chrono::steady_clock::now() < deadline) io.run_one_for(50ms);
        EXPECT_TRUE(done());
    }

    boost::asio::io_context io;
    int pages = 0;
    HttpServer server{io, [this] {
                          ++pages;
                          return std::string("romano_test 1\n");
                      }};
};

TEST_F(HttpServerTest, ServesThePage) {
    const std::string answer = answer_to("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK\r\n"));
    EXPECT_THAT(answer, HasSubstr("text/plain; version=0.0.4"));
    EXPECT_THAT(answer, testing::EndsWith("\r\n\r\nromano_test 1\n"));
}

TEST_F(HttpServerTest, AnswersHeadWithoutTheBody) {
    const std::string answer = answer_to("HEAD /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
    EXPECT_THAT(answer, HasSubstr("Content-Length: 14\r\n"));
    EXPECT_THAT(answer, testing::EndsWith("\r\n\r\n"));
}

TEST_F(HttpServerTest, RefusesWhatItDoesNotServe) {
    EXPECT_THAT(answer_to("GET / HTTP/1.1\r\nHost: x\r\n\r\n"), HasSubstr(" 404 "));
    EXPECT_THAT(answer_to("DELETE /metrics HTTP/1.1\r\nHost: x\r\n\r\n"), HasSubstr(" 405 "));
    EXPECT_THAT(answer_to("\x7f\x45\x4c\x46 garbage\r\n\r\n"), HasSubstr(" 400 "));
    EXPECT_EQ(pages, 0);
}

TEST_F(HttpServerTest, RefusesAHeaderWithoutEnd) {
    const std::string long_header = "GET /metrics HTTP/1.1\r\nX: " + std::string(3000, 'x');
    EXPECT_THAT(answer_to(long_header + std::string(3000, 'x') + "\r\n\r\n"),
                testing::Not(HasSubstr(" 200 ")));
    EXPECT_THAT(answer_to("GET /metrics HTTP/1.1\r\nContent-Length: 99999\r\n\r\n"),
                testing::Not(HasSubstr(" 200 ")));
}

TEST_F(HttpServerTest, ClosesOnAClientThatSaysNothing) {
    const auto silent = client();
    const auto slow = client();
    boost::asio::write(slow->socket, boost::asio::buffer(std::string("GET /met")));
    runs_until([&] { return silent->closed && slow->closed; });
    EXPECT_EQ(silent->heard, "");
}

TEST_F(HttpServerTest, ManySilentClientsKeepNobodyOutForLong) {
    std::vector<std::shared_ptr<Client>> silent;
    for (std::size_t i = 0; i < HttpServer::most_connections; ++i) silent.push_back(client());
    const auto beyond = client();  // closed at once
    runs_until([&] { return beyond->closed; });
    EXPECT_FALSE(silent.front()->closed);
    runs_until([&] { return silent.front()->closed && silent.back()->closed; });
    EXPECT_THAT(answer_to("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n"), HasSubstr(" 200 "));
}

TEST_F(HttpServerTest, MakesThePageAtMostTenTimesASecond) {
    const auto began = std::chrono::steady_clock::now();
    for (int i = 0; i < 40; ++i) {
        EXPECT_THAT(answer_to("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n"), HasSubstr(" 200 "));
    }
    const auto took = std::chrono::steady_clock::now() - began;
    EXPECT_LE(pages, 1 + took / HttpServer::page_lives);
}

TEST_F(HttpServerTest, SaysWhyAPortCannotBeServed) {
    HttpServer second(io, [] { return std::string(); });
    EXPECT_TRUE(
        second.open(*net::parse_endpoint("127.0.0.1:" + std::to_string(server.address().port))));
}

}  // namespace
}  // namespace romano::metrics::http_server_test
