#include "tests/system/metrics_page.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <sstream>
#include <thread>

#include "broker/net/socket_address.h"

namespace romano::system {

std::string metrics_page_at(const Endpoint& address) {
    const auto to = net::to_socket_address(address);
    const int socket = ::socket(to.any.sa_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    std::string answer;
    const std::string request = "GET /metrics HTTP/1.1\r\nHost: broker\r\n\r\n";
    if (::connect(socket, &to.any, to.size) == 0 &&
        ::send(socket, request.data(), request.size(), MSG_NOSIGNAL) > 0) {
        std::array<char, 4096> part{};
        for (ssize_t size = 0; (size = ::recv(socket, part.data(), part.size(), 0)) > 0;) {
            answer.append(part.data(), static_cast<std::size_t>(size));
        }
    }
    ::close(socket);
    return answer;
}

bool metrics_come_to_say(const Endpoint& address, const std::string& series, double at_least,
                         double at_most) {
    const std::string begin = series + ' ';
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{30};
    while (std::chrono::steady_clock::now() < deadline) {
        std::istringstream page(metrics_page_at(address));
        for (std::string line; std::getline(page, line);) {
            if (!line.starts_with(begin)) continue;
            const double value = std::stod(line.substr(begin.size()));
            if (value >= at_least && value <= at_most) return true;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds{20});  // it is made anew as often
    }
    return false;
}

}  // namespace romano::system
