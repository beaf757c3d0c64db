#include "overlay/sim/broker_network.h"

#include <algorithm>
#include <array>
#include <utility>

namespace romano::sim {

using cluster::Delivery;

class BrokerNetwork::Port final : public overlay::Transport {
public:
    Port(BrokerNetwork& network, const broker::LogId& process)
        : network_(network), process_(process) {}
    ~Port() override { network_.detach(process_); }
    Port(const Port&) = delete;
    Port& operator=(const Port&) = delete;

    void start(Receiver receiver) override { receiver_ = std::move(receiver); }
    void send(const overlay::Outgoing& message) override { network_.send(process_, message); }
    void receive(overlay::Envelope envelope) {
        if (receiver_) receiver_(std::move(envelope));
    }

private:
    BrokerNetwork& network_;
    broker::LogId process_;
    Receiver receiver_;
};

std::unique_ptr<overlay::Transport> BrokerNetwork::attach(const broker::LogId& process, Node node,
                                                          OnLink on_link) {
    auto port = std::make_unique<Port>(*this, process);
    peers_[process] = {node, port.get(), std::move(on_link)};
    node_of_[process] = node;
    for (const auto& [other, peer] : peers_) {
        if (other != process) match(process, other);
    }
    return port;
}

void BrokerNetwork::match(const broker::LogId& a, const broker::LogId& b) {
    const auto soon = [this] {
        return events_.now() + random_.between(Duration{0}, options_.match_after_max);
    };
    matched_at_[{a, b}] = soon();
    matched_at_[{b, a}] = soon();
}

void BrokerNetwork::detach(const broker::LogId& process) {
    for (const auto& [other, peer] : peers_) {
        if (other == process || !is_matched(process, other)) continue;
        tell_of_link(other, process, election::Link::lost);
    }
    for (auto& [id, stream] : streams_) {
        const auto& [from, to, delivery] = id;
        if (to == process || (from == process && is_held_up(id))) {
            stream.pending.clear();
        } else if (from == process) {
            // Nobody repeats what was lost on its first way: the reader never passes the gap.
            const auto gap = std::ranges::find_if(
                stream.pending, [&](const Pending& p) { return p.on_wire > events_.now(); });
            stream.pending.erase(gap, stream.pending.end());
        }
    }
    std::erase_if(streams_, [](const auto& entry) { return entry.second.pending.empty(); });
    peers_.erase(process);
    std::erase_if(matched_at_, [&](const auto& entry) {
        return entry.first.first == process || entry.first.second == process;
    });
}

void BrokerNetwork::tell_of_link(const broker::LogId& to, const broker::LogId& about,
                                 election::Link link) {
    const auto receiver = peers_.find(to);
    const auto subject = peers_.find(about);
    if (receiver == peers_.end() || subject == peers_.end() || !receiver->second.on_link) return;
    if (cuts_.is_cut(subject->second.node, receiver->second.node)) return;
    events_.after(options_.quality.delay(random_), [this, to, about, link] {
        const auto peer = peers_.find(to);
        if (peer == peers_.end()) return;
        trace_.note(events_.now(), "link", to.broker, "to", about.broker, static_cast<int>(link));
        peer->second.on_link(about, link);
    });
}

void BrokerNetwork::break_link(Node from, Node to) {
    for (const auto& [first, peer] : peers_) {
        for (const auto& [second, other] : peers_) {
            if (peer.node == from && other.node == to) {
                tell_of_link(first, second, election::Link::lost);
            }
        }
    }
}

void BrokerNetwork::send(const broker::LogId& from, const overlay::Outgoing& outgoing) {
    const bool is_to_one = outgoing.to.has_value();
    const Delivery usual = cluster::delivery_of(outgoing.message);
    const Delivery delivery = is_to_one && usual == Delivery::log ? Delivery::direct : usual;
    const std::size_t octets = options_.octets_of ? options_.octets_of(outgoing.message) : 0;
    count(traffic_[node_of_.at(from)].sent, delivery, octets);
    const auto message = std::make_shared<const Sample>(Sample{outgoing.message, octets});
    for (const auto& [to, peer] : peers_) {
        if (to == from || (outgoing.to && *outgoing.to != to.broker)) continue;
        if (!is_matched(from, to)) continue;
        const StreamId id{from, to, delivery};
        if (delivery == Delivery::log || delivery == Delivery::direct) {
            send_reliable(id, message);
        } else {
            send_best_effort(id, message);
        }
    }
}

bool BrokerNetwork::is_matched(const broker::LogId& from, const broker::LogId& to) const {
    const auto matched = matched_at_.find({from, to});
    return matched != matched_at_.end() && matched->second <= events_.now();
}

void BrokerNetwork::send_reliable(const StreamId& id, const Shared& message) {
    Stream& stream = streams_[id];
    Instant on_wire = events_.now();
    while (random_.happens(options_.quality.loss_ppm)) on_wire += options_.repeat_after;
    const Instant due = std::max(stream.last_due, on_wire + options_.quality.delay(random_));
    stream.last_due = due;
    stream.pending.push_back({due, on_wire, message});
    events_.at(due, [this, id] { pump(id); });
}

bool BrokerNetwork::is_held_up(const StreamId& id) const {
    const auto& [from, to, delivery] = id;
    const auto receiver = peers_.find(to);
    if (receiver == peers_.end()) return true;
    if (stalled_.contains(receiver->second.node)) return true;
    const auto sender = peers_.find(from);  // gone: these are its last words, on their way
    return sender != peers_.end() && cuts_.is_cut(sender->second.node, receiver->second.node);
}

void BrokerNetwork::pump(const StreamId& id) {
    for (;;) {
        const auto stream = streams_.find(id);
        if (stream == streams_.end() || stream->second.pending.empty()) return;
        if (stream->second.pending.front().due > events_.now() || is_held_up(id)) return;
        const Shared message = stream->second.pending.front().message;
        stream->second.pending.pop_front();
        deliver(id, message);
    }
}

void BrokerNetwork::send_best_effort(const StreamId& id, const Shared& message) {
    const std::uint64_t number = ++newest_sent_[id];
    if (random_.happens(options_.quality.loss_ppm)) return;
    Instant arrival = events_.now() + options_.quality.delay(random_);
    if (!options_.overtaking) {
        Instant& last = last_arrival_[id];
        arrival = last = std::max(last, arrival);
    }
    events_.at(arrival, [this, id, number, message] {
        if (is_held_up(id)) return;
        std::uint64_t& newest = newest_delivered_[id];
        if (number <= newest) return;
        newest = number;
        deliver(id, message);
    });
}

void BrokerNetwork::deliver(const StreamId& id, const Shared& message) {
    const auto& [from, to, delivery] = id;
    const auto peer = peers_.find(to);
    if (peer == peers_.end()) return;
    count(traffic_[peer->second.node].received, delivery, message->octets);
    trace_.note(events_.now(), "broker", node_of_.at(from), "->", peer->second.node,
                message->message);
    peer->second.port->receive({from, message->message});
}

void BrokerNetwork::count(TrafficByDelivery& traffic, Delivery delivery, std::size_t octets) const {
    if (!options_.octets_of) return;
    Traffic& counted = traffic[delivery];
    ++counted.messages;
    counted.octets += octets;
}

void BrokerNetwork::cut(Node from, Node to) {
    trace_.note(events_.now(), "cut", from, "->", to);
    cuts_.cut(from, to, events_.now());
}

void BrokerNetwork::join(Node from, Node to) {
    const auto since = cuts_.cut_since(from, to);
    if (!since) return;
    trace_.note(events_.now(), "join", from, "->", to);
    cuts_.join(from, to);
    if (events_.now() - *since > options_.lease) part_for_long(from, to);
    pump_all();
}

void BrokerNetwork::join_all() {
    std::vector<Node> nodes;
    for (const auto& [process, peer] : peers_) nodes.push_back(peer.node);
    for (const Node from : nodes) {
        for (const Node to : nodes) join(from, to);
    }
    cuts_.join_all();
}

void BrokerNetwork::stall(Node node) {
    stalled_.try_emplace(node, events_.now());
}

void BrokerNetwork::go_on(Node node) {
    const auto since = stalled_.find(node);
    if (since == stalled_.end()) return;
    const bool long_gone = events_.now() - since->second > options_.lease;
    stalled_.erase(since);
    if (long_gone) {
        for (const auto& [process, peer] : peers_) {
            if (peer.node != node) part_for_long(node, peer.node);
        }
    }
    pump_all();
}

void BrokerNetwork::part_for_long(Node a, Node b) {
    for (const auto& [first, peer] : peers_) {
        if (peer.node != a) continue;
        for (const auto& [second, other] : peers_) {
            if (other.node != b) continue;
            for (const Delivery delivery : {Delivery::log, Delivery::direct}) {
                streams_.erase({first, second, delivery});
                streams_.erase({second, first, delivery});
            }
            match(first, second);
        }
    }
}

void BrokerNetwork::pump_all() {
    for (const auto& [id, stream] : streams_) {
        if (stream.pending.empty()) continue;
        events_.after(options_.quality.delay(random_), [this, id = id] { pump(id); });
    }
}

}  // namespace romano::sim
