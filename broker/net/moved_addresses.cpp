#include "broker/net/moved_addresses.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>

#include "broker/net/socket_address.h"

namespace romano::net {
namespace {

using namespace std::chrono_literals;
using boost::system::error_code;

constexpr std::chrono::milliseconds renew_every = 1s;
constexpr auto lease = 5s;
constexpr auto neighbours_are_asked_again_after = 100ms;
constexpr int announcements = 3;  // a frame may be lost
// The machine that had the address may be alive, and name it once more as its own: when it asks
// where a robot is, to refuse what came for its dead broker.
constexpr auto announced_again_after = 100ms;
constexpr int quick_announcements = 10;

/// What a socket hears that wants the address for itself; 0: it may have it.
int why_not_bound(const Endpoint& address) {
    const SocketAddress wanted = to_socket_address(address);
    const int fd = ::socket(wanted.any.sa_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return errno;
    const int error = ::bind(fd, &wanted.any, wanted.size) == 0 ? 0 : errno;
    ::close(fd);
    return error;
}

/// A socket of this machine is bound there.
bool is_served(const Endpoint& address) {
    return why_not_bound(address) == EADDRINUSE;
}

bool is_of_this_machine(Endpoint address) {
    address.port = 0;
    return why_not_bound(address) == 0;
}

error_code add_on(const Endpoint& address, InterfaceIndex interface) {
    // Where these are refused, clients of an address that goes back may have to say something
    // twice, and brokers that were cut off need a second more to be back.
    if (address.family == Endpoint::Family::ipv4) (void)ask_neighbours_as_itself(interface);
    (void)ask_neighbours_again_after(neighbours_are_asked_again_after, address.family, interface);
    return add_address(address, interface, lease);
}

}  // namespace

MovedAddresses::~MovedAddresses() {
    for (const auto& [address, moved] : moved_) let_go(address, moved);
}

void MovedAddresses::let_go(const Endpoint& address, const Moved& moved) {
    if (moved.added && !is_served(address)) (void)remove_address(address, moved.interface);
}

bool MovedAddresses::can_add(const Endpoint& address) {
    return may_add_addresses() && interface_towards(address).has_value();
}

bool MovedAddresses::can_serve(const Endpoint& address) {
    return is_of_this_machine(address) || can_add(address);
}

void MovedAddresses::forget_earlier_life(const Endpoint& address) {
    const auto interface = interface_towards(address);
    if (interface && is_leased(address) && !is_served(address))
        (void)remove_address(address, *interface);
}

error_code MovedAddresses::add(const Endpoint& address) {
    const auto interface = interface_towards(address);
    if (!interface) return make_error_code(boost::system::errc::address_not_available);
    if (const auto error = add_on(address, *interface)) return error;
    moved_.insert_or_assign(address, Moved{.interface = *interface, .added = true});
    wait();
    return {};
}

// Also when a socket is bound there: it is a stranger's, of all addresses of the machine perhaps,
// and robots would be led to it.
void MovedAddresses::take_back(const Endpoint& address) {
    const auto moved = moved_.find(address);
    if (moved == moved_.end()) return;
    (void)remove_address(address, moved->second.interface);
    moved_.erase(moved);
}

error_code MovedAddresses::lease_on(const Endpoint& address) {
    const auto moved = moved_.find(address);
    const bool is_ours = moved != moved_.end() && moved->second.added;
    return is_ours || !is_leased(address) ? error_code{} : add(address);
}

void MovedAddresses::announce(const Endpoint& address) {
    auto moved = moved_.find(address);
    if (moved == moved_.end()) {
        const auto interface = interface_towards(address);
        if (!interface) return;
        moved = moved_.emplace(address, Moved{.interface = *interface}).first;
    }
    moved->second.announcements_left = announcements;
    moved->second.quick_announcements_left = quick_announcements;
    // Whoever may not send it serves all the same: on one host nobody has to be told.
    (void)neighbours_.announce(address, moved->second.interface);
    wait();
}

void MovedAddresses::remove(const Endpoint& address) {
    const auto moved = moved_.find(address);
    if (moved == moved_.end()) return;
    let_go(address, moved->second);
    moved_.erase(moved);
}

void MovedAddresses::wait() {
    if (moved_.empty()) return;
    const bool is_quick = std::ranges::any_of(
        moved_, [](const auto& entry) { return entry.second.quick_announcements_left > 0; });
    const auto at =
        std::chrono::steady_clock::now() + (is_quick ? announced_again_after : renew_every);
    if (waiting_ && timer_.expiry() <= at) return;
    waiting_ = true;
    timer_.expires_at(at);
    timer_.async_wait([this](const error_code& cancelled) {
        if (cancelled) return;
        waiting_ = false;
        renew();
        wait();
    });
}

void MovedAddresses::renew() {
    for (auto& [address, moved] : moved_) {
        if (moved.added) renew_lease(address, moved);
        if (may_repeat_(address)) (void)neighbours_.announce(address, moved.interface);
        --(moved.quick_announcements_left > 0 ? moved.quick_announcements_left
                                              : moved.announcements_left);
    }
    std::erase_if(moved_, [](const auto& entry) {
        return !entry.second.added && entry.second.announcements_left <= 0;
    });
}

/// The interface may have been made anew since, under another number.
void MovedAddresses::renew_lease(const Endpoint& address, Moved& moved) {
    auto error = add_address(address, moved.interface, lease);
    if (error) {
        if (const auto interface = interface_towards(address)) {
            error = add_on(address, *interface);
            if (!error) moved.interface = *interface;
        }
    }
    const bool was_lost = std::exchange(moved.lost, bool{error});
    if (error && !was_lost) on_lost_(address, error);
}

}  // namespace romano::net
