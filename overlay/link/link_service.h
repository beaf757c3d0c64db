// Links between brokers: TCP connections that the kernel closes when a process dies, so that its
// peers know within a millisecond (election/link.h decides what that means; memory_keeper.h, why
// it does not take longer).
//
// Each broker dials every peer whose beacon names an address, and watches that one connection; the
// peer only holds the other end. When it closes, the peer is dialled again at once: if its port
// refuses, the process is gone and the link is lost; if it answers, the connection alone was cut,
// and nothing is said; if nothing comes back, beacons must tell, and it is tried again later.
//
// Whoever dials must say a Hello from a broker that we know, to this very process, and prove that
// it knows our secret; anything else, and anything after it, is dropped and counted. So is whoever
// answers in a peer's name without that one's secret. Connections are bounded. One thread: that of
// the io_context.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/error_code.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>

#include "broker/core/log_position.h"
#include "election/failure_detector.h"
#include "overlay/link/hello.h"
#include "overlay/link/memory_keeper.h"
#include "romano/base/endpoint.h"

namespace romano::link {

struct LinkCounters {
    std::uint64_t dialled = 0;
    std::uint64_t up = 0;
    std::uint64_t lost = 0;
    std::uint64_t strangers =
        0;                       // dropped: no Hello in time, garbage, unknown, unproven, not to us
    std::uint64_t too_many = 0;  // dropped: beyond the bound
};

class LinkService {
public:
    static constexpr std::size_t most_peers = 256;
    static constexpr std::size_t most_guests = 2 * most_peers;

    /// `process` is a peer with its incarnation at its start, as its beacons name it.
    using OnLink = std::function<void(const broker::LogId& process, election::Link link)>;

    LinkService(boost::asio::io_context& io, const broker::LogId& self, OnLink on_link);
    ~LinkService();
    LinkService(const LinkService&) = delete;
    LinkService& operator=(const LinkService&) = delete;

    /// Takes links at a free port of `host` (its port is ignored). Family none in address() until
    /// then.
    [[nodiscard]] boost::system::error_code open(const Endpoint& host);
    [[nodiscard]] const Endpoint& address() const { return address_; }
    /// For the own particulars: peers prove with it that they may dial.
    [[nodiscard]] const Secret& secret() const { return secret_; }

    /// The particulars of `process` name this address and secret. Dials it unless it is dialled
    /// already; an older process of the same broker is forgotten.
    void on_address(const broker::LogId& process, const Endpoint& address, const Secret& secret);
    /// The broker was heard. Dials it, where on_address() named it and it is not dialled already:
    /// an attempt that failed is made again as long as the broker is heard.
    void on_heartbeat(broker::BrokerId broker);

    [[nodiscard]] const LinkCounters& counters() const { return counters_; }

private:
    class Watch;
    class Guest;

    void accept();
    void accept_later();
    /// Its beacons were heard.
    [[nodiscard]] bool knows(const broker::LogId& process) const;

    boost::asio::io_context& io_;
    MemoryKeeper memory_keeper_;
    broker::LogId self_;
    OnLink on_link_;
    Endpoint address_;
    Secret secret_ = sixteen_random_octets();
    boost::asio::ip::tcp::acceptor acceptor_;
    boost::asio::steady_timer pause_;
    std::map<broker::BrokerId, std::shared_ptr<Watch>> watches_;
    std::set<std::shared_ptr<Guest>> guests_;
    LinkCounters counters_;
};

}  // namespace romano::link
