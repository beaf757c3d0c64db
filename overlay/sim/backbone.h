// What carries the datagrams of brokers in place of links with a delay and a loss: a channel that
// all of them share. BrokerNetwork goes on promising what overlay/transport.h says, and repeats
// what must arrive.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "overlay/sim/link.h"

namespace romano::sim {

/// Around a message between brokers. DDSI-RTPS 2.3 section 9.4: header 20, INFO_TS 12, DATA 24; the
/// encapsulation of its payload 4, and what sample.idl has before the body 28.
inline constexpr std::size_t rtps_data_octets = 88;
/// A reader's answer to reliable data: header 20, INFO_DST 16, ACKNACK 28.
inline constexpr std::size_t rtps_acknack_octets = 64;

class Backbone {
public:
    /// The datagram has come to that node.
    using Arrived = std::function<void(Node at)>;
    /// It has left the sender, or found no room there.
    using Left = std::function<void()>;

    virtual ~Backbone() = default;

    /// To one node, or to all that hear it. It comes later, or is lost.
    virtual void send(Node from, std::optional<Node> to, std::size_t octets, Arrived arrived,
                      Left left) = 0;
    /// Brokers that are too far from each other never find each other.
    [[nodiscard]] virtual bool reaches(Node from, Node to) const = 0;
};

}  // namespace romano::sim
