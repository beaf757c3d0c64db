#include "tests/system/small_nat.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <optional>

#include "broker/net/socket_address.h"

namespace romano::system {
namespace {

int socket_at(const Endpoint& where) {
    const auto address = net::to_socket_address(where);
    const int made = socket(address.any.sa_family, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    EXPECT_EQ(bind(made, &address.any, address.size), 0);
    return made;
}

}  // namespace

SmallNat::SmallNat(const Endpoint& inside, const Endpoint& outside, const Endpoint& broker)
    : inside_(inside),
      outside_(outside),
      broker_(broker),
      inner_(socket_at(inside)),
      outer_(socket_at(outside)),
      thread_([this] { carry(); }) {}

SmallNat::~SmallNat() {
    ends_ = true;
    thread_.join();
    close(inner_);
    close(outer_);
}

void SmallNat::move() {
    const int next = socket_at(outside_);  // while the old one is there: another port
    const std::lock_guard lock(moving_);
    close(outer_);
    outer_ = next;
}

void SmallNat::carry() {
    const auto broker = net::to_socket_address(broker_);
    sockaddr_storage client{};
    socklen_t client_size = 0;
    std::array<std::uint8_t, 65'536> datagram{};
    while (!ends_) {
        std::array<pollfd, 2> ends{};
        {
            const std::lock_guard lock(moving_);
            ends = {pollfd{inner_, POLLIN, 0}, pollfd{outer_, POLLIN, 0}};
        }
        if (poll(ends.data(), ends.size(), 10) <= 0) continue;
        const std::lock_guard lock(moving_);
        for (;;) {
            sockaddr_storage from{};
            socklen_t size = sizeof from;
            auto* any = reinterpret_cast<sockaddr*>(&from);
            const auto got = recvfrom(inner_, datagram.data(), datagram.size(), 0, any, &size);
            if (got < 0) break;
            client = from;
            client_size = size;
            (void)sendto(outer_, datagram.data(), static_cast<std::size_t>(got), 0, &broker.any,
                         broker.size);
        }
        for (;;) {
            const auto got = recv(outer_, datagram.data(), datagram.size(), 0);
            if (got < 0) break;
            (void)sendto(inner_, datagram.data(), static_cast<std::size_t>(got), 0,
                         reinterpret_cast<const sockaddr*>(&client), client_size);
        }
    }
}

}  // namespace romano::system
