#include "experiments/robots/socket_client.h"

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/buffer.hpp>

namespace romano::experiments::socket_client_test {
namespace {

using mqttsn::MsgType;

TEST(SentCounts, CountDatagramsByTypeWithEitherFormOfTheLength) {
    SentCounts counts;
    const std::array<std::uint8_t, 2> pingreq = {0x02, 0x16};
    const std::array<std::uint8_t, 5> long_publish = {0x01, 0x01, 0x2C, 0x0C, 0x00};
    counts.count(pingreq);
    counts.count(pingreq);
    counts.count(long_publish);
    counts.count({});
    EXPECT_EQ(counts.of(MsgType::pingreq), 2u);
    EXPECT_EQ(counts.of(MsgType::publish), 1u);
    EXPECT_EQ(counts.of(MsgType::connect), 0u);
}

TEST(Port, KeepsItsOwnAddressWhenItTalksToAnotherBroker) {
    using boost::asio::ip::udp;
    boost::asio::io_context io;
    const udp::endpoint anywhere{boost::asio::ip::address_v4::loopback(), 0};
    udp::socket one{io, anywhere};
    udp::socket other{io, anywhere};
    Sockets sockets{io};
    const auto port = sockets.open_port(one.local_endpoint(), {}, [](Bytes) {});
    const auto heard_from = [](udp::socket& broker) {
        std::array<std::uint8_t, 8> room{};
        udp::endpoint from;
        broker.receive_from(boost::asio::buffer(room), from);
        return from;
    };
    const std::array<std::uint8_t, 2> pingreq = {0x02, 0x16};
    port->send(pingreq);
    const udp::endpoint first = heard_from(one);
    port->talk_to(other.local_endpoint());
    port->send(pingreq);
    EXPECT_EQ(heard_from(other), first);
}

TEST(Resolving, KnowsAddressesOfBothFamilies) {
    boost::asio::io_context io;
    EXPECT_EQ(resolve_broker(io, "127.0.0.1", 1883).address().to_string(), "127.0.0.1");
    EXPECT_EQ(resolve_broker(io, "::1", 1883).address().to_string(), "::1");
    EXPECT_EQ(resolve_broker(io, "::1", 1884).port(), 1884);
}

TEST(Resolving, NamesTheHostThatIsUnknown) {
    boost::asio::io_context io;
    try {
        (void)resolve_broker(io, "no such host", 1883);
        FAIL() << "found";
    } catch (const std::runtime_error& error) {
        EXPECT_EQ(std::string{error.what()}.find("cannot find the host `no such host`: "), 0u);
    }
}

}  // namespace
}  // namespace romano::experiments::socket_client_test
