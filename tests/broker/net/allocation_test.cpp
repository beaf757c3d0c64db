// The way of a datagram through the UDP shell costs no allocation once its storage has grown.
// A program of its own, because it replaces operator new.

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <new>

#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"
#include "broker/net/udp_service.h"

namespace {
std::size_t allocations = 0;
}  // namespace

void* operator new(std::size_t size) {
    ++allocations;
    if (void* room = std::malloc(size)) return room;
    throw std::bad_alloc{};
}
void operator delete(void* room) noexcept {
    std::free(room);
}
void operator delete(void* room, std::size_t) noexcept {
    std::free(room);
}

namespace romano::net::allocation_test {
namespace {

using namespace std::chrono_literals;

class Echo : public DatagramHandler {
public:
    explicit Echo(boost::asio::io_context& io) : udp(io, *this) {}

    void on_datagram(const Endpoint& via, const Endpoint& from, Bytes octets) override {
        std::ranges::copy(octets, actions_.reserve(octets.size()).begin());
        actions_.push(broker::Send{.via = via,
                                   .to = {from, {}},
                                   .offset = actions_.commit(octets.size()),
                                   .size = static_cast<std::uint32_t>(octets.size())});
        ++echoed;
    }
    void on_batch_end() override {
        udp.carry_out(actions_);
        actions_.clear();
    }

    int echoed = 0;

private:
    broker::Actions actions_;

public:
    UdpService udp;
};

TEST(UdpService, EchoesWithoutAllocatingInTheSteadyState) {
    boost::asio::io_context io;
    Echo echo(io);
    Endpoint service;
    ASSERT_FALSE(echo.udp.open(*parse_endpoint("127.77.1.9:0"), Bind::alone, &service));
    const int client = socket(AF_INET, SOCK_DGRAM, 0);
    const SocketAddress to = to_socket_address(service);
    ASSERT_EQ(connect(client, &to.any, to.size), 0);
    const std::array<char, 40> datagram{};
    const auto echo_some = [&](int count) {
        const int end = echo.echoed + count;
        for (int i = 0; i < count; ++i) {
            ASSERT_EQ(send(client, datagram.data(), datagram.size(), 0), 40);
        }
        while (echo.echoed < end) io.run_one_for(1s);
    };
    for (int i = 0; i < 20; ++i) echo_some(50);  // storage grows
    const std::size_t before = allocations;
    for (int i = 0; i < 20; ++i) echo_some(50);
    EXPECT_EQ(allocations, before);
    close(client);
}

}  // namespace
}  // namespace romano::net::allocation_test
