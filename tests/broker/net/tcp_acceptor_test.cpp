#include "broker/net/tcp_acceptor.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "broker/net/endpoint_text.h"

namespace romano::net::tcp_acceptor_test {
namespace {

using boost::asio::ip::tcp;

struct Acceptor : testing::Test {
    tcp::socket client() {
        tcp::socket out(io);
        out.connect({boost::asio::ip::address_v4::loopback(), acceptor.address().port});
        return out;
    }

    boost::asio::io_context io;
    std::vector<tcp::socket> taken;
    TcpAcceptor acceptor{io, [this](tcp::socket socket) { taken.push_back(std::move(socket)); }};
};

TEST_F(Acceptor, TakesConnectionsAtThePortThatItWasGiven) {
    EXPECT_EQ(acceptor.address().family, Endpoint::Family::none);
    ASSERT_FALSE(acceptor.open(*parse_endpoint("127.0.0.1:0"), 4));
    const tcp::socket one = client();
    const tcp::socket other = client();
    while (taken.size() < 2) io.run_one();  // ctest limits the time
    EXPECT_EQ(taken.size(), 2U);
}

TEST_F(Acceptor, SaysWhyAnAddressCannotBeServed) {
    ASSERT_FALSE(acceptor.open(*parse_endpoint("127.0.0.1:0"), 4));
    TcpAcceptor second(io, nullptr);
    EXPECT_EQ(second.open(acceptor.address(), 4), boost::asio::error::address_in_use);
    EXPECT_TRUE(TcpAcceptor(io, nullptr).open(*parse_endpoint("192.0.2.1:0"), 4));
}

}  // namespace
}  // namespace romano::net::tcp_acceptor_test
