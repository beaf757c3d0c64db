// Modelled IEEE 802.15.4 cells between real robots and real brokers: UDP sockets on both sides, and
// between them the channel of overlay/radio, whose virtual time is held to the machine's clock.
//
// A robot talks to its cell's address as to its broker. Who speaks there first takes the next free
// place around the cell's router; its datagrams come to the broker from a socket of its own, so
// that the broker tells robots apart by their addresses.
//
// What a broker sends to its multicast group (romano/mqttsn/cell.md) is one broadcast frame in its
// cell. A robot's radio passes it on when the robot has subscribed to `$cell`, which is seen as it
// goes by, as a switch sees IGMP; it comes to the robot's own socket, as its radio heard it.
#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "broker/net/core_timer.h"
#include "experiments/measure/latency_histogram.h"
#include "overlay/radio/radio_network.h"
#include "overlay/sim/world.h"
#include "romano/base/endpoint.h"

namespace romano::experiments {

struct BridgedCell {
    Endpoint listen;  // where robots find it
    Endpoint broker;
};

struct RadioBridgeOptions {
    std::vector<BridgedCell> cells;
    std::optional<Endpoint> group;  // the brokers' --cell-group
    std::size_t robots = 10;        // places around each router
    std::size_t channels = 16;
    std::optional<std::uint32_t> router_baud = 115'200;
    std::optional<std::uint32_t> robot_baud = 115'200;
    double router_distance_m = 30;
    std::uint64_t seed = 1;
    /// A datagram that is handed over later than this after its time on the channel came late.
    std::chrono::microseconds most_lag{5'000};
};

/// One sentence on what cannot be; empty when all can.
[[nodiscard]] std::optional<std::string> problem_with(const RadioBridgeOptions& options);

struct RadioBridgeFigures {
    std::uint64_t to_brokers = 0;  // datagrams handed over
    std::uint64_t to_robots = 0;
    std::uint64_t to_cells = 0;       // datagrams to the group, each once on the air
    std::uint64_t too_large = 0;      // for 6LoWPAN
    std::uint64_t without_place = 0;  // of robots that found no place free
    std::uint64_t lost_in_queues = 0;
    std::uint64_t given_up_on_air = 0;  // frames
    double air_share = 0;               // of the time, the busiest router's cell
    LatencyHistogram lag;               // how late datagrams were handed over
    std::uint64_t late = 0;             // of these

    /// More than one datagram in a hundred came late: what was measured is not the channel's.
    [[nodiscard]] bool has_lagged() const { return late * 100 > lag.count(); }
};

class RadioBridge {
public:
    /// Throws boost::system::system_error when an address cannot be bound.
    RadioBridge(boost::asio::io_context& io, const RadioBridgeOptions& options,
                std::function<void()> on_lag);
    RadioBridge(const RadioBridge&) = delete;
    RadioBridge& operator=(const RadioBridge&) = delete;

    [[nodiscard]] RadioBridgeFigures figures();

private:
    using Udp = boost::asio::ip::udp;
    static constexpr std::size_t room = 65'536;

    /// A place at a router, and the robot that has it. In the group while that listens.
    struct Place {
        Place(boost::asio::io_context& io, std::size_t in_cell, const Endpoint& own)
            : cell(in_cell), address(own), to_broker(io) {}

        std::size_t cell;
        Endpoint address;  // in the world
        Udp::socket to_broker;
        std::optional<Udp::endpoint> robot;
        bool listens = false;
        Instant heard{};
    };
    struct Cell {
        Cell(boost::asio::io_context& io, const BridgedCell& cell);

        Udp::socket socket;
        Udp::endpoint broker;
        std::map<Udp::endpoint, Place*> robots;
    };

    void open_place(std::size_t cell, std::size_t number);
    void open_group(const Endpoint& group);
    void hand_to_broker(const Endpoint& from, Bytes datagram);
    void hear_robots(std::size_t cell);
    void hear_broker(Place& place);
    void hear_group();
    void let_listen(Place& place, bool listens);
    [[nodiscard]] Place* place_of(std::size_t cell, const Udp::endpoint& robot);
    void send(const Endpoint& from, const Endpoint& to, Bytes datagram);
    void on_handed_over();
    void catch_up();
    [[nodiscard]] Instant now() const;

    RadioBridgeOptions options_;
    Instant began_;
    std::function<void()> on_lag_;
    sim::World world_;
    radio::RadioNetwork network_;
    std::vector<std::unique_ptr<Cell>> cells_;
    std::deque<Place> places_;  // cell after cell
    std::map<Endpoint, Place*> place_at_;
    std::optional<Udp::socket> group_;
    std::array<std::uint8_t, room> octets_{};
    RadioBridgeFigures figures_;
    boost::asio::io_context& io_;
    net::CoreTimer timer_;
};

}  // namespace romano::experiments
