#include "overlay/sim/broker_network.h"

#include <algorithm>
#include <utility>

namespace romano::sim {

using cluster::Delivery;

namespace {
constexpr int slowest_repeat = 16;  // times repeat_after
}

class BrokerNetwork::Port final : public overlay::Transport {
public:
    Port(BrokerNetwork& network, SharedPeer self) : network_(network), self_(std::move(self)) {}
    ~Port() override { network_.detach(self_); }
    Port(const Port&) = delete;
    Port& operator=(const Port&) = delete;

    void start(Receiver receiver) override { receiver_ = std::move(receiver); }
    void send(const overlay::Outgoing& message) override { network_.send(self_, message); }
    void receive(const overlay::Envelope& envelope) {
        if (receiver_) receiver_(envelope);
    }

private:
    BrokerNetwork& network_;
    SharedPeer self_;
    Receiver receiver_;
};

bool BrokerNetwork::Way::is_over() const {
    const bool is_dead = from->port == nullptr || to->port == nullptr;
    return is_dead && log.pending.empty() && direct.pending.empty();
}

BrokerNetwork::Stream* BrokerNetwork::Way::stream(Delivery delivery) {
    if (delivery == Delivery::log) return &log;
    return delivery == Delivery::direct ? &direct : nullptr;
}

BrokerNetwork::Datagrams& BrokerNetwork::Way::datagrams(Delivery delivery) {
    return delivery == Delivery::beacon ? beacons : forwards;
}

std::unique_ptr<overlay::Transport> BrokerNetwork::attach(const broker::LogId& process, Node node,
                                                          OnLink on_link) {
    const auto self =
        std::make_shared<Peer>(Peer{process, node, &traffic_[node], std::move(on_link), nullptr});
    auto port = std::make_unique<Port>(*this, self);
    self->port = port.get();
    peers_[process] = self;
    for (const auto& [other, peer] : peers_) {
        if (other != process) match(self, peer);
    }
    sort_ways();
    return port;
}

void BrokerNetwork::sort_ways() {
    ways_from_.clear();
    for (const auto& [pair, way] : ways_) ways_from_[pair.first].push_back(way);
}

void BrokerNetwork::match(const SharedPeer& a, const SharedPeer& b) {
    const auto meet = [this](const SharedPeer& from, const SharedPeer& to) {
        SharedWay& way = ways_[{from->process, to->process}];
        const bool is_theirs = way && way->from == from && way->to == to;
        if (!is_theirs) way = std::make_shared<Way>(Way{from, to});
        way->matched_at = events_.now() + random_.between(Duration{0}, options_.match_after_max);
        if (backbone_ != nullptr && !backbone_->reaches(from->node, to->node)) {
            way->matched_at = never;
        }
    };
    meet(a, b);
    meet(b, a);
}

void BrokerNetwork::detach(const SharedPeer& process) {
    for (const auto& [other, peer] : peers_) {
        if (peer == process) continue;
        const Way& way = *ways_.at({process->process, other});
        if (way.matched_at <= events_.now()) tell_of_link(*peer, *process, election::Link::lost);
    }
    for (auto& [pair, way] : ways_) {
        for (Stream* stream : {&way->log, &way->direct}) {
            if (way->to == process || (way->from == process && is_held_up(*way))) {
                stream->pending.clear();
            } else if (way->from == process) {
                // Nobody repeats what was lost on its first way: the reader never passes the gap.
                const auto gap = std::ranges::find_if(
                    stream->pending, [&](const Pending& p) { return p.on_wire > events_.now(); });
                stream->pending.erase(gap, stream->pending.end());
            }
        }
    }
    process->port = nullptr;
    peers_.erase(process->process);
    std::erase_if(ways_, [](const auto& entry) { return entry.second->is_over(); });
    sort_ways();
}

void BrokerNetwork::tell_of_link(const Peer& to, const Peer& about, election::Link link) {
    if (!to.on_link || cuts_.is_cut(about.node, to.node)) return;
    events_.after(options_.quality.delay(random_), [this, to = to.process, about = about.process,
                                                    link] {
        const auto peer = peers_.find(to);
        if (peer == peers_.end()) return;
        trace_.note(events_.now(), "link", to.broker, "to", about.broker, static_cast<int>(link));
        peer->second->on_link(about, link);
    });
}

void BrokerNetwork::break_link(Node from, Node to) {
    for (const auto& [first, peer] : peers_) {
        for (const auto& [second, other] : peers_) {
            if (peer->node == from && other->node == to) {
                tell_of_link(*peer, *other, election::Link::lost);
            }
        }
    }
}

void BrokerNetwork::send(const SharedPeer& from, const overlay::Outgoing& outgoing) {
    const bool is_to_one = outgoing.to.has_value();
    const Delivery usual = cluster::delivery_of(outgoing.message);
    const Delivery delivery = is_to_one && usual == Delivery::log ? Delivery::direct : usual;
    const std::size_t octets = options_.octets_of ? options_.octets_of(outgoing.message) : 0;
    count(from->traffic->sent, delivery, octets);
    const auto sample = std::make_shared<const Sample>(
        Sample{{from->process, outgoing.message}, octets, ++samples_, events_.now(), delivery});
    if (backbone_ != nullptr) return send_on_backbone(from, outgoing, sample);
    for (const SharedWay& way : ways_of(from, outgoing.to)) {
        if (Stream* stream = way->stream(delivery)) {
            send_reliable(way, *stream, sample);
        } else {
            send_best_effort(way, sample);
        }
    }
}

/// To those that are matched, in their order.
std::vector<BrokerNetwork::SharedWay> BrokerNetwork::ways_of(
    const SharedPeer& from, const std::optional<broker::BrokerId>& to) const {
    std::vector<SharedWay> ways;
    const auto found = ways_from_.find(from->process);
    if (found == ways_from_.end()) return ways;
    for (const SharedWay& way : found->second) {
        if (to && *to != way->to->process.broker) continue;
        if (way->to->port != nullptr && way->matched_at <= events_.now()) ways.push_back(way);
    }
    return ways;
}

void BrokerNetwork::send_reliable(const SharedWay& way, Stream& stream, const Shared& sample) {
    Instant on_wire = events_.now();
    while (random_.happens(options_.quality.loss_ppm)) on_wire += options_.repeat_after;
    const Instant due = std::max(stream.last_due, on_wire + options_.quality.delay(random_));
    stream.last_due = due;
    stream.pending.push_back({due, on_wire, sample});
    events_.at(due, [this, way, &stream] { pump(*way, stream); });
}

void BrokerNetwork::send_on_backbone(const SharedPeer& from, const overlay::Outgoing& outgoing,
                                     const Shared& sample) {
    std::optional<Node> to;
    std::vector<SharedWay> reliable;
    for (const SharedWay& way : ways_of(from, outgoing.to)) {
        if (outgoing.to) to = way->to->node;
        Stream* stream = way->stream(sample->delivery);
        if (stream == nullptr) continue;
        stream->pending.push_back({never, never, sample});
        reliable.push_back(way);
    }
    if (outgoing.to && !to) return;
    backbone_->send(from->node, to, sample->octets + rtps_data_octets, arrival_of(from, sample),
                    [this, reliable = std::move(reliable), sample] {
                        for (const SharedWay& way : reliable) {
                            repeat_later(way, sample, options_.repeat_after);
                        }
                    });
}

Backbone::Arrived BrokerNetwork::arrival_of(const SharedPeer& from, const Shared& sample) {
    return [this, from, sample](Node at) { on_backbone_arrival(from, at, *sample); };
}

void BrokerNetwork::on_backbone_arrival(const SharedPeer& from, Node at, const Sample& sample) {
    for (const SharedWay& way : ways_of(from, std::nullopt)) {
        if (way->to->node != at || way->matched_at > sample.sent_at || is_held_up(*way)) continue;
        Stream* stream = way->stream(sample.delivery);
        if (stream == nullptr) return take_best_effort(*way, sample);
        for (Pending& pending : stream->pending) {
            if (pending.sample.get() != &sample) continue;
            pending.due = pending.on_wire = std::min(pending.due, events_.now());
        }
        backbone_->send(
            at, from->node, rtps_acknack_octets, [](Node) {}, [] {});
        return pump(*way, *stream);
    }
}

/// As long as both live and it has not come.
void BrokerNetwork::repeat_later(const SharedWay& way, const Shared& sample, Duration after) {
    events_.after(after, [this, way, sample, after] {
        if (way->from->port == nullptr || way->to->port == nullptr) return;
        const auto& pending = way->stream(sample->delivery)->pending;
        const auto found = std::ranges::find(pending, sample, &Pending::sample);
        if (found == pending.end() || found->due != never) return;
        if (found != pending.begin() || is_held_up(*way)) {
            return repeat_later(way, sample, options_.repeat_after);
        }
        const Duration next = std::min(2 * after, slowest_repeat * options_.repeat_after);
        backbone_->send(way->from->node, way->to->node, sample->octets + rtps_data_octets,
                        arrival_of(way->from, sample),
                        [this, way, sample, next] { repeat_later(way, sample, next); });
    });
}

bool BrokerNetwork::is_held_up(const Way& way) const {
    if (way.to->port == nullptr || stalled_.contains(way.to->node)) return true;
    // Of a dead sender these are its last words, on their way.
    return way.from->port != nullptr && cuts_.is_cut(way.from->node, way.to->node);
}

void BrokerNetwork::pump(Way& way, Stream& stream) {
    while (!stream.pending.empty()) {
        if (stream.pending.front().due > events_.now() || is_held_up(way)) return;
        const Shared sample = std::move(stream.pending.front().sample);
        stream.pending.pop_front();
        deliver(way, *sample);
    }
}

void BrokerNetwork::send_best_effort(const SharedWay& way, const Shared& sample) {
    if (random_.happens(options_.quality.loss_ppm)) return;
    Instant arrival = events_.now() + options_.quality.delay(random_);
    if (!options_.overtaking) {
        Instant& last = way->datagrams(sample->delivery).last_arrival;
        arrival = last = std::max(last, arrival);
    }
    events_.at(arrival, [this, way, sample] {
        if (!is_held_up(*way)) take_best_effort(*way, *sample);
    });
}

void BrokerNetwork::take_best_effort(Way& way, const Sample& sample) {
    Datagrams& datagrams = way.datagrams(sample.delivery);
    if (sample.number <= datagrams.newest_delivered) return;
    datagrams.newest_delivered = sample.number;
    deliver(way, sample);
}

void BrokerNetwork::deliver(Way& way, const Sample& sample) {
    if (way.to->port == nullptr) return;
    count(way.to->traffic->received, sample.delivery, sample.octets);
    trace_.note(events_.now(), "broker", way.from->node, "->", way.to->node,
                sample.envelope.message);
    way.to->port->receive(sample.envelope);
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
    for (const auto& [process, peer] : peers_) nodes.push_back(peer->node);
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
            if (peer->node != node) part_for_long(node, peer->node);
        }
    }
    pump_all();
}

void BrokerNetwork::part_for_long(Node a, Node b) {
    for (const auto& [first, peer] : peers_) {
        if (peer->node != a) continue;
        for (const auto& [second, other] : peers_) {
            if (other->node != b) continue;
            for (const Pair& pair : {Pair{first, second}, Pair{second, first}}) {
                for (Stream* stream : {&ways_.at(pair)->log, &ways_.at(pair)->direct}) {
                    stream->pending.clear();
                    stream->last_due = {};
                }
            }
            match(peer, other);
        }
    }
}

void BrokerNetwork::pump_all() {
    for (const auto& [pair, way] : ways_) {
        for (Stream* stream : {&way->log, &way->direct}) {
            if (stream->pending.empty()) continue;
            events_.after(options_.quality.delay(random_),
                          [this, way = way, stream] { pump(*way, *stream); });
        }
    }
}

}  // namespace romano::sim
