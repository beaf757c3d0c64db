#include "experiments/testbed/host/multicast_trial.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace romano::experiments {
namespace {

constexpr const char* trial_group = "239.255.0.1";  // DDSI-RTPS 2.3, section 9.6.1.4
constexpr std::uint16_t trial_port = 7399;          // beside the ports of DDS, which begin at 7400
constexpr const char* trial_mark = "romano-testbed ";
constexpr int headers_octets = 28;  // of IPv4 and UDP
constexpr std::size_t most_heard = 1000;

}  // namespace

MulticastTrial::MulticastTrial(std::string name, const std::string& interface)
    : name_(std::move(name)), socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    ip_mreqn membership{};
    membership.imr_multiaddr.s_addr = ::inet_addr(trial_group);
    membership.imr_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_port = htons(trial_port);
    const int on = 1;
    const int off = 0;
    const int whole = IP_PMTUDISC_DO;
    const auto set = [this](int level, int option, const auto& value) {
        return ::setsockopt(socket_, level, option, &value, sizeof value) == 0;
    };
    const bool can = set(SOL_SOCKET, SO_REUSEADDR, on) &&
                     ::bind(socket_, reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0 &&
                     set(IPPROTO_IP, IP_ADD_MEMBERSHIP, membership) &&
                     set(IPPROTO_IP, IP_MULTICAST_IF, membership) &&
                     set(IPPROTO_IP, IP_MULTICAST_LOOP, off) &&
                     set(IPPROTO_IP, IP_MTU_DISCOVER, whole);
    if (!can) trouble_ = std::strerror(errno);
    ifreq mtu{};
    interface.copy(mtu.ifr_name, IFNAMSIZ - 1);
    if (::ioctl(socket_, SIOCGIFMTU, &mtu) == 0) {
        longest_octets_ = std::clamp(mtu.ifr_mtu - headers_octets, 0, 65'507);
    }
}

MulticastTrial::~MulticastTrial() {
    if (socket_ >= 0) ::close(socket_);
}

void MulticastTrial::shout() {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(trial_port);
    to.sin_addr.s_addr = ::inet_addr(trial_group);
    std::string words = trial_mark + name_ + " ";
    for (const std::size_t length : {words.size(), static_cast<std::size_t>(longest_octets_)}) {
        words.resize(std::max(words.size(), length), '.');
        const ssize_t sent = ::sendto(socket_, words.data(), words.size(), 0,
                                      reinterpret_cast<const sockaddr*>(&to), sizeof to);
        if (sent < 0 && trouble_.empty()) trouble_ = std::strerror(errno);
    }
}

const std::map<std::string, int>& MulticastTrial::heard() {
    std::array<char, 65'536> octets{};
    while (true) {
        const ssize_t size = ::recv(socket_, octets.data(), octets.size(), MSG_DONTWAIT);
        if (size < 0) return heard_;
        const std::string_view words{octets.data(), static_cast<std::size_t>(size)};
        if (!words.starts_with(trial_mark)) continue;
        const std::string_view rest = words.substr(std::string_view{trial_mark}.size());
        const std::string name{rest.substr(0, rest.find(' '))};
        if (heard_.size() >= most_heard && !heard_.contains(name)) continue;
        heard_[name] = std::max(heard_[name], static_cast<int>(size));
    }
}

}  // namespace romano::experiments
