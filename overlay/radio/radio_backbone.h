// Brokers that talk to each other on IEEE 802.15.4: each has a radio for that, all of them one PAN
// on one channel. What is for all is a broadcast, unacknowledged; what is for one is a unicast. A
// message that is longer than a datagram goes in several, and comes when all of them have come.
//
// The channel itself is RadioNetwork's, which calls this class with what happens to its radios.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "overlay/radio/propagation.h"
#include "overlay/sim/backbone.h"
#include "overlay/sim/event_queue.h"

namespace romano::radio {

struct BackboneRadio {
    sim::Node broker;
    Place place;
};

class RadioBackbone final : public sim::Backbone {
public:
    /// Radios go by their numbers, in the order of `radios`. A radio that was given something is
    /// ready again at on_ready().
    using Transmit = std::function<void(std::size_t from, std::optional<std::size_t> to,
                                        const std::vector<std::uint8_t>& octets)>;

    /// Each radio keeps so many datagrams; a message for which there is no room is lost.
    RadioBackbone(sim::EventQueue& events, const RadioModel& model,
                  std::vector<BackboneRadio> radios, std::size_t queue, Transmit transmit);

    void send(sim::Node from, std::optional<sim::Node> to, std::size_t octets, Arrived arrived,
              Left left) override;
    [[nodiscard]] bool reaches(sim::Node from, sim::Node to) const override;

    void on_ready(std::size_t radio);
    void on_received(std::size_t at, std::size_t from);

    [[nodiscard]] const Place& place(std::size_t radio) const { return radios_[radio].place; }
    [[nodiscard]] std::size_t size() const { return radios_.size(); }
    /// Messages, for want of room.
    [[nodiscard]] std::uint64_t lost() const { return lost_; }

private:
    struct Message {
        std::size_t pieces;
        std::size_t waiting;  // pieces that have not left
        Arrived arrived;
        Left left;
        std::map<std::size_t, std::size_t> pieces_at;  // by radio: how many have come
    };
    struct Piece {
        std::optional<std::size_t> to;
        std::size_t octets;
        std::shared_ptr<Message> message;
    };

    [[nodiscard]] std::size_t number_of(sim::Node broker) const;
    void transmit_next(std::size_t radio);

    sim::EventQueue& events_;
    RadioModel model_;
    std::vector<BackboneRadio> radios_;
    std::size_t queue_most_;
    Transmit transmit_;
    std::vector<std::deque<Piece>> queues_;  // the first piece is with the radio
    std::uint64_t lost_ = 0;
};

}  // namespace romano::radio
