#include "broker/net/service_manager.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

namespace romano::net {
namespace {

std::string_view environment(const char* name) {
    const char* value = std::getenv(name);
    return value == nullptr ? "" : value;
}

/// 0 when there is no such number.
std::int64_t number(std::string_view text) {
    std::int64_t value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
}

/// A datagram socket that sends to `path`, which begins with '@' in the abstract name space; -1
/// when there is none.
int connected_to(std::string_view path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (path.empty() || path.size() >= sizeof address.sun_path) return -1;
    std::copy(path.begin(), path.end(), address.sun_path);
    if (path[0] == '@') address.sun_path[0] = '\0';
    const int handle = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
    if (handle >= 0 && ::connect(handle, reinterpret_cast<sockaddr*>(&address), size) != 0) {
        ::close(handle);
        return -1;
    }
    return handle;
}

/// Half of the time after which the manager loses patience with this process; 0: it has enough of
/// it.
std::chrono::microseconds sign_every() {
    const std::int64_t pid = number(environment("WATCHDOG_PID"));
    if (pid != 0 && pid != ::getpid()) return std::chrono::microseconds{0};
    return std::chrono::microseconds{number(environment("WATCHDOG_USEC")) / 2};
}

}  // namespace

ServiceManager::ServiceManager(boost::asio::io_context& io)
    : timer_(io), every_(sign_every()), socket_(connected_to(environment("NOTIFY_SOCKET"))) {}

ServiceManager::~ServiceManager() {
    if (socket_ >= 0) ::close(socket_);
}

void ServiceManager::tell(const std::string& sentences) const {
    // A manager that does not listen just now is no reason to stop serving.
    if (socket_ >= 0) (void)::send(socket_, sentences.data(), sentences.size(), MSG_NOSIGNAL);
}

void ServiceManager::serving(const std::string& status) {
    tell("READY=1\nSTATUS=" + status);
    if (socket_ >= 0 && every_.count() > 0) give_signs_of_life();
}

void ServiceManager::ending() {
    tell("STOPPING=1");
    timer_.cancel();
}

void ServiceManager::give_signs_of_life() {
    tell("WATCHDOG=1");
    timer_.expires_after(every_);
    timer_.async_wait([this](const auto& error) {
        if (!error) give_signs_of_life();
    });
}

}  // namespace romano::net
