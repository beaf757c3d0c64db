// The server on a real socket, with clients that behave and clients that do not.

#include "experiments/web/web_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <deque>
#include <string>

#include "broker/net/endpoint_text.h"

namespace romano::experiments::web_server_test {
namespace {

using namespace std::chrono_literals;
using boost::asio::ip::tcp;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Nobody final : Steering {
    std::uint64_t carry_out(const Orders&) override { return 0; }
};

/// Server and clients share one thread: what a client waits for, the server does meanwhile.
struct Served : ::testing::Test {
    Served() {
        const auto failed = server.open(*net::parse_endpoint("127.0.0.1:0"));
        EXPECT_FALSE(failed) << failed.message();
    }

    class Client {
    public:
        explicit Client(Served& served) : io_(served.io), socket_(io_) {
            socket_.connect(
                {boost::asio::ip::address_v4::loopback(), served.server.address().port});
            socket_.non_blocking(true);
        }
        void send(const std::string& text) {
            boost::system::error_code error;
            boost::asio::write(socket_, boost::asio::buffer(text), error);
        }
        /// Until these words came, or the server closed; what came so far.
        std::string receive_until(const std::string& words) {
            for (int turns = 0; turns < 2000 && text_.find(words) == std::string::npos; ++turns) {
                io_.restart();
                io_.run_for(5ms);
                std::array<char, 8192> room{};
                boost::system::error_code error;
                const std::size_t size = socket_.read_some(boost::asio::buffer(room), error);
                text_.append(room.data(), size);
                if (error == boost::asio::error::eof ||
                    error == boost::asio::error::connection_reset) {
                    text_ += "(closed)";
                    break;
                }
            }
            return std::exchange(text_, {});
        }
        void close() { socket_.close(); }

    private:
        boost::asio::io_context& io_;
        tcp::socket socket_;
        std::string text_;
    };

    static std::string get(const std::string& path, const std::string& more = {}) {
        return "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1\r\n" + more + "\r\n";
    }

    boost::asio::io_context io;
    FleetPicture picture{Duration{0}};
    Nobody nobody;
    WebApi api{picture, nobody, std::vector<std::string>{}};
    WebServer server{io, picture, api};
};

TEST_F(Served, AConnectionServesSeveralRequests) {
    Client client{*this};
    client.send(get("/api/state"));
    EXPECT_THAT(client.receive_until("\"talks\":[]}\n"), StartsWith("HTTP/1.1 200 OK\r\n"));
    client.send(get("/nothing"));
    EXPECT_THAT(client.receive_until("}\n"), StartsWith("HTTP/1.1 404"));
    client.send("HEAD / HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n");
    const std::string head = client.receive_until("(closed)");
    EXPECT_THAT(head, HasSubstr("Content-Security-Policy: default-src 'none'"));
    EXPECT_THAT(head, ::testing::EndsWith("\r\n\r\n(closed)")) << "a HEAD has no body";
}

TEST_F(Served, WhatIsTooLongOrNoHttpIsRefused) {
    Client long_header{*this};
    long_header.send(get("/", "X: " + std::string(20'000, 'x') + "\r\n"));
    EXPECT_THAT(long_header.receive_until("(closed)"), StartsWith("HTTP/1.1 413"));
    Client long_body{*this};
    long_body.send("POST /api/stop HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 99999\r\n\r\n");
    EXPECT_THAT(long_body.receive_until("(closed)"), StartsWith("HTTP/1.1 413"));
    Client no_http{*this};
    no_http.send("\x16\x03\x01 hello\r\n\r\n");
    EXPECT_THAT(no_http.receive_until("(closed)"), StartsWith("HTTP/1.1 400"));
}

TEST_F(Served, AStreamBeginsWithTheWholeAndGoesOnWithChanges) {
    Client client{*this};
    client.send(get("/api/events"));
    const std::string whole = client.receive_until("\n\n");
    EXPECT_THAT(whole, HasSubstr("Content-Type: text/event-stream"));
    EXPECT_THAT(whole, HasSubstr("\r\n\r\nevent: state\ndata: {\"version\":0"));
    picture.on_link(Instant{1h}, true);
    const std::string change = client.receive_until("\n\n");
    EXPECT_THAT(change, StartsWith("event: change\ndata: {\"version\":1"));
    EXPECT_THAT(change, HasSubstr("\"is_linked\":true"));
}

TEST_F(Served, StreamsAreBoundedAndEndWithTheirReaders) {
    std::deque<Client> clients;
    for (std::size_t n = 0; n < WebServer::most_streams; ++n) {
        clients.emplace_back(*this).send(get("/api/events"));
        EXPECT_THAT(clients.back().receive_until("event: state"), HasSubstr("200 OK"));
    }
    Client one_more{*this};
    one_more.send(get("/api/events"));
    EXPECT_THAT(one_more.receive_until("}\n"), StartsWith("HTTP/1.1 503"));
    clients.front().close();
    for (int tries = 0; tries < 100; ++tries) {
        one_more.send(get("/api/events"));
        if (one_more.receive_until("}\n").starts_with("HTTP/1.1 200")) return;
    }
    ADD_FAILURE() << "the place of a reader who left stayed taken";
}

TEST_F(Served, ConnectionsBeyondTheMostAreClosedAtOnce) {
    std::deque<Client> clients;
    for (std::size_t n = 0; n < WebServer::most_connections; ++n) clients.emplace_back(*this);
    clients.back().send(get("/api/state"));
    EXPECT_THAT(clients.back().receive_until("\"seconds\""), HasSubstr("200 OK"));
    Client one_more{*this};
    EXPECT_EQ(one_more.receive_until("(closed)"), "(closed)");
}

}  // namespace
}  // namespace romano::experiments::web_server_test
