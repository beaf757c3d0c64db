#include "overlay/link/keep_alive.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

namespace romano::link {
namespace {

constexpr int asked_after_s = 30;
constexpr int asked_again_after_s = 10;
constexpr int times_asked = 3;

}  // namespace

void keep_alive(boost::asio::ip::tcp::socket& socket) {
    const auto set = [&socket](int level, int name, int value) {
        (void)::setsockopt(socket.native_handle(), level, name, &value, sizeof value);
    };
    set(IPPROTO_TCP, TCP_KEEPIDLE, asked_after_s);
    set(IPPROTO_TCP, TCP_KEEPINTVL, asked_again_after_s);
    set(IPPROTO_TCP, TCP_KEEPCNT, times_asked);
    set(SOL_SOCKET, SO_KEEPALIVE, 1);
}

}  // namespace romano::link
