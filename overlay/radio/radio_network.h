// Cells of robots as the client network of a simulated world: what goes between a robot and anybody
// else goes by the border router of the robot's cell.
//
//     broker ── host's queue ── UART ── border router's queue ~~ 802.15.4 ~~ robot's queue ── UART
//     ── robot
//
// The world's virtual time drives the channel: its next event is one of the world's events, and it
// runs no further. One seed is one run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "overlay/radio/channel.h"
#include "overlay/radio/propagation.h"
#include "overlay/radio/radio_backbone.h"
#include "overlay/radio/serial_line.h"
#include "overlay/sim/client_network.h"
#include "overlay/sim/event_queue.h"
#include "overlay/sim/world.h"
#include "romano/base/endpoint.h"

namespace romano::radio {

struct RadioRobot {
    Endpoint address;  // by which the world's clients know it
    Place place;
};

/// A robot that stands in several cells can join each of them; it begins in the first. Its radio
/// hears the cell that it has joined, and nothing else.
struct RadioCell {
    unsigned channel = lowpan::last_channel;
    Place router;
    std::vector<RadioRobot> robots;
};

/// Where brokers talk on the air, too.
struct BackboneOnAir {
    unsigned channel = lowpan::last_channel;
    std::vector<BackboneRadio> radios;
};

struct RadioOptions {
    std::vector<RadioCell> cells;
    std::optional<BackboneOnAir> backbone;
    RadioModel model;
    std::optional<std::uint32_t> router_baud = 115'200;  // empty: no line
    std::optional<std::uint32_t> robot_baud = 115'200;
    std::size_t host_queue =
        500;  // datagrams before the router's UART: Linux's tun device keeps 500
    std::size_t radio_queue = 8;  // of each radio: RIOT's GNRC_NETIF keeps 8
};

/// One sentence on what cannot be; empty when all can.
[[nodiscard]] std::optional<std::string> problem_with(const RadioOptions& options);

class RadioNetwork {
public:
    /// The world lives longer. Options are without problem.
    RadioNetwork(sim::World& world, const RadioOptions& options);
    ~RadioNetwork();
    RadioNetwork(const RadioNetwork&) = delete;
    RadioNetwork& operator=(const RadioNetwork&) = delete;

    void move(const Endpoint& robot, const Place& place);
    /// From now on it is in this cell, with its channel. What waits for it elsewhere is lost.
    void join(const Endpoint& robot, std::size_t cell);
    /// The border router loses its power, for good.
    void switch_off_router(std::size_t cell);
    /// The strength of a frame that the robot would hear from the cell's router now.
    [[nodiscard]] double hears_dbm(const Endpoint& robot, std::size_t cell);

    [[nodiscard]] const lowpan::Counters& counters() const { return channel_->counters(); }
    [[nodiscard]] const lowpan::Air& sent_by_router(std::size_t cell) const {
        return channel_->sent_by({cell, 0});
    }
    /// Null when brokers have no radios.
    [[nodiscard]] sim::Backbone* backbone() { return backbone_.get(); }
    [[nodiscard]] lowpan::Air sent_by_brokers() const;
    [[nodiscard]] lowpan::Air sent_by_robots(std::size_t cell) const;
    /// When a host's queue first was full: the paper's "buffer overflow".
    [[nodiscard]] std::optional<Instant> first_overflow() const { return first_overflow_; }
    /// For want of room, anywhere.
    [[nodiscard]] std::uint64_t lost() const;

private:
    struct Station;  // a radio with its queue and its line to the host
    /// Of a robot: one in each cell that it can join.
    struct Radios {
        lowpan::Device joined;
        std::vector<lowpan::Device> all;
        [[nodiscard]] std::optional<lowpan::Device> in(std::size_t cell) const;
    };

    bool carry(const Carried& datagram);
    bool carry_to_listeners(const Carried& datagram);
    void enter(Station& station, const Carried& datagram);
    void add_station(const lowpan::Device& device, const Place& place);
    bool queue_for_radio(Station& station, const Carried& datagram);
    bool hand_over(const Carried& datagram);
    void transmit(Station& station);
    void on_ready(const lowpan::Device& device);
    void on_received(const lowpan::Device& at, const lowpan::Device& from,
                     const std::vector<std::uint8_t>& octets);
    void rearm();
    void add_backbone();
    /// Its radios are those of one cell more.
    [[nodiscard]] bool is_on_backbone(const lowpan::Device& device) const {
        return device.cell == options_.cells.size();
    }
    [[nodiscard]] const Place& place_of(const lowpan::Device& device) const;
    [[nodiscard]] double dbm(const lowpan::Device& from, const lowpan::Device& to);
    [[nodiscard]] double link_dbm(const lowpan::Device& from, const lowpan::Device& to);

    sim::World& world_;
    RadioOptions options_;
    std::map<lowpan::Device, std::unique_ptr<Station>> stations_;
    std::map<Endpoint, Radios> robots_;
    std::map<std::pair<lowpan::Device, lowpan::Device>, RadioLink> links_;
    std::optional<Instant> first_overflow_;
    Instant timer_ = never;
    std::unique_ptr<RadioBackbone> backbone_;
    std::unique_ptr<lowpan::Channel> channel_;  // goes first: it calls the others
};

}  // namespace romano::radio
