// The network between brokers: what overlay/transport.h promises, and not more.
//
// Modelled on Cyclone DDS. A process and a peer match some milliseconds after both can hear each
// other; before that nothing passes. Beacons and best-effort messages are lost, delayed, and
// dropped when a newer one came first. Reliable messages come in order; what is lost is repeated
// later, unless the sender died first: then the stream ends at the gap, at another place for each
// receiver. A cut or a stalled process holds a stream up; after `lease` the two are no match any
// more and what the stream held is gone.
//
// A backbone may carry the datagrams instead of links with a delay and a loss: then a message to
// all is sent once, and a reliable one again to each reader that has not got it, the oldest first,
// some time after the former copy has left the sender.
// An answer of each reader takes its share of the channel; whether it comes does not matter here.
//
// Links (overlay/link): a process that dies is lost to its matched peers a moment later, unless the
// way from it is cut.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "election/failure_detector.h"
#include "overlay/sim/backbone.h"
#include "overlay/sim/event_queue.h"
#include "overlay/sim/link.h"
#include "overlay/sim/trace.h"
#include "overlay/transport.h"
#include "romano/base/random.h"

namespace romano::sim {

/// What one node's processes sent or got, of one delivery. A message to all is sent once.
struct Traffic {
    std::uint64_t messages = 0;
    std::uint64_t octets = 0;
};
using TrafficByDelivery = std::map<cluster::Delivery, Traffic>;

struct BrokerNetworkOptions {
    LinkQuality quality;
    /// The size of a message on a real network. Without it traffic is not counted.
    std::function<std::size_t(const cluster::ClusterMessage&)> octets_of{};
    /// A best-effort message comes before one that was sent earlier, which is then dropped. Not on
    /// one wire.
    bool overtaking = true;
    Duration repeat_after{std::chrono::milliseconds{20}};  // a lost reliable message
    Duration match_after_max{std::chrono::milliseconds{150}};
    Duration lease{std::chrono::seconds{1}};
};

class BrokerNetwork {
public:
    using OnLink = std::function<void(const broker::LogId& process, election::Link link)>;

    BrokerNetwork(EventQueue& events, Trace& trace, const BrokerNetworkOptions& options,
                  std::uint64_t seed)
        : events_(events), trace_(trace), options_(options), random_(seed) {}

    /// The process's end of the network; destroying it is the process's death.
    [[nodiscard]] std::unique_ptr<overlay::Transport> attach(const broker::LogId& process,
                                                             Node node, OnLink on_link = {});
    /// A firewall begins to refuse: to `from` that looks like the death of `to`.
    void break_link(Node from, Node to);

    void set_quality(const LinkQuality& quality) { options_.quality = quality; }
    /// Before anybody is attached; it lives longer. Null: links of that quality.
    void set_backbone(Backbone* backbone) { backbone_ = backbone; }
    [[nodiscard]] const BrokerNetworkOptions& options() const { return options_; }

    void cut(Node from, Node to);
    void join(Node from, Node to);
    void join_all();
    [[nodiscard]] const Cuts& cuts() const { return cuts_; }

    /// A stopped process: its kernel's buffers take some of what comes, its peers wait.
    void stall(Node node);
    void go_on(Node node);

    [[nodiscard]] const TrafficByDelivery& sent_by(Node node) { return traffic_[node].sent; }
    [[nodiscard]] const TrafficByDelivery& received_by(Node node) {
        return traffic_[node].received;
    }

private:
    class Port;
    /// On its way to one peer or to many.
    struct Sample {
        cluster::Envelope envelope;
        std::size_t octets;    // 0 when nobody counts
        std::uint64_t number;  // later ones have higher numbers
        Instant sent_at;
        cluster::Delivery delivery;
    };
    using Shared = std::shared_ptr<const Sample>;

    struct NodeTraffic {
        TrafficByDelivery sent;
        TrafficByDelivery received;
    };
    /// One life of a broker's process; what it sent may outlive it.
    struct Peer {
        broker::LogId process;
        Node node;
        NodeTraffic* traffic;
        OnLink on_link;
        Port* port;  // null: it is dead
    };
    using SharedPeer = std::shared_ptr<Peer>;

    struct Pending {
        Instant due;      // arrives then, if nothing stands in the way; on a backbone nobody knows
        Instant on_wire;  // the sender must live until then
        Shared sample;
    };
    /// One writer's reliable samples to one reader, of one delivery.
    struct Stream {
        std::deque<Pending> pending{};
        Instant last_due{};
    };
    /// One writer's best-effort samples to one reader, of one delivery.
    struct Datagrams {
        std::uint64_t newest_delivered = 0;  // older ones are dropped
        Instant last_arrival{};              // where there is no overtaking
    };
    /// From one process to another one.
    struct Way {
        SharedPeer from;
        SharedPeer to;
        Instant matched_at = never;
        Datagrams beacons{};
        Datagrams forwards{};
        Stream log{};
        Stream direct{};

        /// Null when that delivery is none of theirs.
        [[nodiscard]] Stream* stream(cluster::Delivery delivery);
        [[nodiscard]] Datagrams& datagrams(cluster::Delivery delivery);
        [[nodiscard]] bool is_over() const;  // and all of it has come
    };
    using SharedWay = std::shared_ptr<Way>;
    using Pair = std::pair<broker::LogId, broker::LogId>;

    void detach(const SharedPeer& process);
    void count(TrafficByDelivery& traffic, cluster::Delivery delivery, std::size_t octets) const;
    void send(const SharedPeer& from, const overlay::Outgoing& outgoing);
    [[nodiscard]] std::vector<SharedWay> ways_of(const SharedPeer& from,
                                                 const std::optional<broker::BrokerId>& to) const;
    void sort_ways();
    void send_reliable(const SharedWay& way, Stream& stream, const Shared& sample);
    void send_best_effort(const SharedWay& way, const Shared& sample);
    void send_on_backbone(const SharedPeer& from, const overlay::Outgoing& outgoing,
                          const Shared& sample);
    [[nodiscard]] Backbone::Arrived arrival_of(const SharedPeer& from, const Shared& sample);
    void on_backbone_arrival(const SharedPeer& from, Node at, const Sample& sample);
    void repeat_later(const SharedWay& way, const Shared& sample, Duration after);
    void take_best_effort(Way& way, const Sample& sample);
    void pump(Way& way, Stream& stream);
    void deliver(Way& way, const Sample& sample);
    void match(const SharedPeer& a, const SharedPeer& b);
    void part_for_long(Node a, Node b);
    void pump_all();
    void tell_of_link(const Peer& to, const Peer& about, election::Link link);
    [[nodiscard]] bool is_held_up(const Way& way) const;

    EventQueue& events_;
    Trace& trace_;
    BrokerNetworkOptions options_;
    Random random_;
    Backbone* backbone_ = nullptr;
    std::uint64_t samples_ = 0;
    Cuts cuts_;
    std::map<Node, NodeTraffic> traffic_;
    std::map<Node, Instant> stalled_;
    std::map<broker::LogId, SharedPeer> peers_;  // that live
    std::map<Pair, SharedWay> ways_;
    std::map<broker::LogId, std::vector<SharedWay>> ways_from_;  // the same: most goes to all
};

}  // namespace romano::sim
