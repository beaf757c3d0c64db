// UDP between robots and service addresses: datagrams are lost, delayed, doubled and overtaken.
//
// Overtaking is a link's option: between two hosts of one radio cell there is none, and a PUBREL
// that overtakes the PUBLISH which a new home repeats at once is a new message to any receiver. A
// copy comes right behind its original, as radios make them. One that came behind the next step
// of its exchange would be a new QoS 2 message to any receiver, because PUBREL frees the message id
// (MQTT-SN 1.2 section 6.6): no broker and no client can keep P3 on such a network. What misleads
// nobody may come once more much later.
//
// An address may be bound by several nodes, as with SO_REUSEADDR on one host or with an address
// that moved between hosts: a datagram goes to the newest binding that its sender can reach. Robots
// behind a NAT that keeps source ports have one address together: it knows who of them talks to
// whom. What nobody serves vanishes.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "overlay/sim/event_queue.h"
#include "overlay/sim/link.h"
#include "overlay/sim/trace.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/random.h"

namespace romano::sim {

class ClientNetwork {
public:
    using Receiver = std::function<void(const Endpoint& at, const Endpoint& from, Bytes datagram)>;
    /// True: this datagram does not arrive.
    using Filter = std::function<bool(const Endpoint& from, const Endpoint& to, Bytes datagram)>;
    /// True: it takes this datagram to its receiver, by deliver(), or loses it; links do not. What
    /// is for a group is for each listener: it delivers copies to them.
    using Carrier =
        std::function<bool(Node sender, const Endpoint& from, const Endpoint& to, Bytes datagram)>;
    /// Whether what comes from there is for this binding.
    using Judgement = std::function<bool(const Endpoint& from)>;
    enum class Binding : std::uint64_t {};

    ClientNetwork(EventQueue& events, Trace& trace, std::uint64_t seed)
        : events_(events), trace_(trace), random_(seed), recorder_(seed ^ 0x5EA1) {}

    [[nodiscard]] Binding bind(const Endpoint& address, Node node, Receiver receiver,
                               Judgement takes_from = {});
    void unbind(Binding binding);
    /// What is sent to the group comes to that address too: a datagram for each listener, which its
    /// link loses, delays and doubles by itself. Behind one another go all that one sends to one.
    void join(const Endpoint& group, const Endpoint& listener) { ++groups_[group][listener]; }
    void leave(const Endpoint& group, const Endpoint& listener) {
        if (--groups_[group][listener] == 0) groups_[group].erase(listener);
    }
    [[nodiscard]] bool is_listening(const Endpoint& group, const Endpoint& listener) const {
        const auto found = groups_.find(group);
        return found != groups_.end() && found->second.contains(listener);
    }
    /// Datagrams that were sent to groups.
    [[nodiscard]] std::uint64_t sent_to_groups() const { return sent_to_groups_; }
    [[nodiscard]] bool is_bound(const Endpoint& address) const;

    void send(Node sender, const Endpoint& from, const Endpoint& to, Bytes datagram);

    /// From now on somebody records so many of the datagrams that arrive, whatever they are, and
    /// sends each to the same address again within that time. (What did not arrive would only be
    /// late, and a late QoS 2 PUBLISH misleads any broker, see above.)
    void record(std::uint32_t ppm, Duration played_back_within) {
        recorded_ppm_ = ppm;
        played_back_within_ = played_back_within;
    }
    /// And bends what it recorded: cut, with a bit or its number changed, back to who sent it, or
    /// as it was, but from an address of its own.
    void bend_recorded() { is_bent_ = true; }

    void set_quality(const LinkQuality& quality) { quality_ = quality; }
    [[nodiscard]] const LinkQuality& quality() const { return quality_; }
    [[nodiscard]] Cuts& cuts() { return cuts_; }
    /// For scripted losses.
    void set_filter(Filter filter) { filter_ = std::move(filter); }
    /// For radios.
    void set_carrier(Carrier carrier) { carrier_ = std::move(carrier); }
    /// The datagram is at its receiver's door now.
    void deliver(Node sender, const Endpoint& from, const Endpoint& to, Bytes datagram);

private:
    void send_to_one(Node sender, const Endpoint& from, const Endpoint& to, Bytes datagram);
    void play_back(Node sender, Endpoint from, Endpoint to, Bytes datagram);
    void bend(Endpoint& from, Endpoint& to, std::vector<std::uint8_t>& datagram);

    struct Bound {
        Binding id;
        Node node;
        Receiver receiver;
        Judgement takes_from;  // none: from everywhere
    };

    EventQueue& events_;
    Trace& trace_;
    Random random_;
    Random recorder_;
    std::uint32_t recorded_ppm_ = 0;
    Duration played_back_within_{0};
    bool is_bent_ = false;
    LinkQuality quality_;
    Cuts cuts_;
    Filter filter_;
    Carrier carrier_;
    std::uint64_t last_binding_ = 0;
    std::map<Endpoint, std::vector<Bound>> bound_;  // oldest first
    /// How many listen there, at each address.
    std::map<Endpoint, std::map<Endpoint, unsigned>> groups_;
    std::uint64_t sent_to_groups_ = 0;
    std::map<std::pair<Endpoint, Endpoint>, Instant> last_arrival_;
};

}  // namespace romano::sim
