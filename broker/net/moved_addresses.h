// Service addresses that came to this machine, or back to it: puts them on the interface of their
// network when the machine does not have them, and tells the neighbours.
//
// What was put there is leased, and leased again each second: it goes when this process ends,
// however that happens. As long as it is here the neighbours are told each second, and ten times in
// the first one, because the machine that had it before may be alive without its broker, and answer
// for it.
//
// Several brokers of one machine may serve an address one after the other: whoever takes it leases
// it on, and whoever lets it go leaves it to the one that is bound there by then. So a broker's
// sockets are closed before its MovedAddresses end.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/error_code.hpp>
#include <functional>
#include <map>
#include <utility>

#include "broker/net/machine_address.h"
#include "broker/net/neighbour_announcement.h"
#include "romano/base/endpoint.h"

namespace romano::net {

class MovedAddresses {
public:
    /// Whether the neighbours may be told again of an address that is here.
    using MayRepeat = std::function<bool(const Endpoint& address)>;

    /// What was added here will be gone in a moment, and why. Once, until it can be leased again.
    using OnLost =
        std::function<void(const Endpoint& address, const boost::system::error_code& why)>;

    MovedAddresses(boost::asio::io_context& io, MayRepeat may_repeat, OnLost on_lost)
        : timer_(io), may_repeat_(std::move(may_repeat)), on_lost_(std::move(on_lost)) {}
    /// Removes what was added.
    ~MovedAddresses();
    MovedAddresses(const MovedAddresses&) = delete;
    MovedAddresses& operator=(const MovedAddresses&) = delete;

    /// Could add(), as far as one can know before.
    [[nodiscard]] static bool can_add(const Endpoint& address);
    /// The machine has the address, or could get it.
    [[nodiscard]] static bool can_serve(const Endpoint& address);
    /// Removes what an earlier life of this broker had added before it was killed, unless another
    /// broker of this machine serves it.
    static void forget_earlier_life(const Endpoint& address);
    /// Gives the machine the address.
    [[nodiscard]] boost::system::error_code add(const Endpoint& address);
    /// Undoes add(): the address could not be served here.
    void take_back(const Endpoint& address);
    /// The address is served here from now on: when another broker of this machine had added it,
    /// its lease would end.
    [[nodiscard]] boost::system::error_code lease_on(const Endpoint& address);
    /// Tells the neighbours that the address is here: now, and some times more. Not needed, and not
    /// done, for addresses of the loopback.
    void announce(const Endpoint& address);
    /// Takes it from the machine, if it was added here and nobody else serves it, and says nothing
    /// more about it.
    void remove(const Endpoint& address);

private:
    struct Moved {
        InterfaceIndex interface;
        bool added = false;
        bool lost = false;  // and told of
        int quick_announcements_left = 0;
        int announcements_left = 0;  // behind these; of one that the machine has anyway
    };

    static void let_go(const Endpoint& address, const Moved& moved);
    void wait();
    void renew();
    void renew_lease(const Endpoint& address, Moved& moved);

    boost::asio::steady_timer timer_;
    MayRepeat may_repeat_;
    OnLost on_lost_;
    bool waiting_ = false;
    std::map<Endpoint, Moved> moved_;
    NeighbourAnnouncer neighbours_;
};

}  // namespace romano::net
