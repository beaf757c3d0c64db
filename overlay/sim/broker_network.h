// The network between brokers: what overlay/transport.h promises, and not more.
//
// Modelled on Cyclone DDS. A process and a peer match some milliseconds after both can hear each
// other; before that nothing passes. Beacons and best-effort messages are lost, delayed, and
// dropped when a newer one came first. Reliable messages come in order; what is lost is repeated
// later, unless the sender died first: then the stream ends at the gap, at another place for each
// receiver. A cut or a stalled process holds a stream up; after `lease` the two are no match any
// more and what the stream held is gone.
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
#include <tuple>
#include <vector>

#include "election/failure_detector.h"
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
    struct Sample {
        cluster::ClusterMessage message;
        std::size_t octets;  // 0 when nobody counts
    };
    using Shared = std::shared_ptr<const Sample>;

    struct Peer {
        Node node;
        Port* port;
        OnLink on_link;
    };
    struct Pending {
        Instant due;      // arrives then, if nothing stands in the way
        Instant on_wire;  // the sender must live until then
        Shared message;
    };
    /// One writer's samples to one reader, of one delivery.
    struct Stream {
        std::deque<Pending> pending;
        Instant last_due{};
    };
    using Pair = std::pair<broker::LogId, broker::LogId>;
    using StreamId = std::tuple<broker::LogId, broker::LogId, cluster::Delivery>;

    struct NodeTraffic {
        TrafficByDelivery sent;
        TrafficByDelivery received;
    };

    void detach(const broker::LogId& process);
    void count(TrafficByDelivery& traffic, cluster::Delivery delivery, std::size_t octets) const;
    void send(const broker::LogId& from, const overlay::Outgoing& outgoing);
    void send_reliable(const StreamId& id, const Shared& message);
    void send_best_effort(const StreamId& id, const Shared& message);
    void pump(const StreamId& id);
    void deliver(const StreamId& id, const Shared& message);
    void match(const broker::LogId& a, const broker::LogId& b);
    void part_for_long(Node a, Node b);
    void pump_all();
    void tell_of_link(const broker::LogId& to, const broker::LogId& about, election::Link link);
    [[nodiscard]] bool is_matched(const broker::LogId& from, const broker::LogId& to) const;
    [[nodiscard]] bool is_held_up(const StreamId& id) const;

    EventQueue& events_;
    Trace& trace_;
    BrokerNetworkOptions options_;
    Random random_;
    Cuts cuts_;
    std::map<Node, NodeTraffic> traffic_;
    std::map<Node, Instant> stalled_;
    std::map<broker::LogId, Peer> peers_;
    std::map<broker::LogId, Node> node_of_;  // of all that ever were: their last words are traced
    std::map<Pair, Instant> matched_at_;
    std::map<StreamId, Stream> streams_;
    std::map<StreamId, std::uint64_t> newest_sent_;       // best effort: numbers the samples
    std::map<StreamId, Instant> last_arrival_;            // where there is no overtaking
    std::map<StreamId, std::uint64_t> newest_delivered_;  // older ones are dropped
};

}  // namespace romano::sim
