#include "overlay/sim/client_network.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "romano/mqttsn/decode.h"

namespace romano::sim {
namespace {

using namespace std::chrono_literals;
using mqttsn::MsgType;

constexpr Duration late_copy_after_max = 30ms;

/// A copy behind later steps of its exchange tells the receiver nothing false. Of what begins or
/// ends a session it would, and of QoS 2.
bool may_come_late(Bytes datagram) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return false;
    switch (frame->type) {
        case MsgType::publish: {
            const auto publish = mqttsn::decode_publish(frame->body);
            return publish && publish->qos != mqttsn::Qos::exactly_once;
        }
        case MsgType::puback:
        case MsgType::pubrec:
        case MsgType::pubrel:
        case MsgType::pubcomp:
        case MsgType::register_:
        case MsgType::regack:
        case MsgType::subscribe:
        case MsgType::suback:
            return true;
        default:
            return false;
    }
}

}  // namespace

ClientNetwork::Binding ClientNetwork::bind(const Endpoint& address, Node node, Receiver receiver,
                                           Judgement takes_from) {
    const Binding id{++last_binding_};
    bound_[address].push_back({id, node, std::move(receiver), std::move(takes_from)});
    trace_.note(events_.now(), "bind", address, "node", node);
    return id;
}

void ClientNetwork::unbind(Binding binding) {
    for (auto& [address, bound] : bound_) {
        if (std::erase_if(bound, [&](const Bound& b) { return b.id == binding; }) > 0) {
            trace_.note(events_.now(), "unbind", address);
        }
    }
}

bool ClientNetwork::is_bound(const Endpoint& address) const {
    const auto found = bound_.find(address);
    return found != bound_.end() && !found->second.empty();
}

void ClientNetwork::send(Node sender, const Endpoint& from, const Endpoint& to, Bytes datagram) {
    const auto group = groups_.find(to);
    if (group == groups_.end()) return send_to_one(sender, from, to, datagram);
    ++sent_to_groups_;
    if (carrier_ && carrier_(sender, from, to, datagram)) return;
    for (const auto& [listener, count] : group->second) {
        send_to_one(sender, from, listener, datagram);
    }
}

void ClientNetwork::send_to_one(Node sender, const Endpoint& from, const Endpoint& to,
                                Bytes datagram) {
    const bool dropped =
        (filter_ && filter_(from, to, datagram)) || random_.happens(quality_.loss_ppm);
    trace_.note(events_.now(), from, dropped ? "-x" : "->", to, datagram);
    if (dropped) return;
    if (carrier_ && carrier_(sender, from, to, datagram)) return;
    const int copies = random_.happens(quality_.duplication_ppm) ? 2 : 1;
    Instant arrival = events_.now() + quality_.delay(random_);
    if (!quality_.overtaking) {
        Instant& last = last_arrival_[{from, to}];
        arrival = last = std::max(last, arrival);
    }
    const std::vector<std::uint8_t> octets(datagram.begin(), datagram.end());
    events_.at(arrival, [this, sender, from, to, copies, octets] {
        for (int i = 0; i < copies; ++i) deliver(sender, from, to, octets);
    });
    if (may_come_late(datagram) && random_.happens(quality_.late_copy_ppm)) {
        events_.at(arrival + random_.between(Duration{0}, late_copy_after_max),
                   [this, sender, from, to, octets] { deliver(sender, from, to, octets); });
    }
}

void ClientNetwork::deliver(Node sender, const Endpoint& from, const Endpoint& to, Bytes datagram) {
    const auto found = bound_.find(to);
    if (found == bound_.end()) return;
    const auto newest =
        std::find_if(found->second.rbegin(), found->second.rend(), [&](const Bound& bound) {
            return !cuts_.is_cut(sender, bound.node) &&
                   (!bound.takes_from || bound.takes_from(from));
        });
    if (newest == found->second.rend()) {
        trace_.note(events_.now(), "nobody at", to);
        return;
    }
    const Receiver receiver = newest->receiver;  // may unbind itself
    if (recorder_.happens(recorded_ppm_)) play_back(sender, from, to, datagram);
    receiver(to, from, datagram);
}

void ClientNetwork::play_back(Node sender, Endpoint from, Endpoint to, Bytes datagram) {
    std::vector<std::uint8_t> recorded(datagram.begin(), datagram.end());
    if (is_bent_) bend(from, to, recorded);
    events_.at(events_.now() + recorder_.between(Duration{0}, played_back_within_),
               [this, sender, from, to, recorded] { deliver(sender, from, to, recorded); });
}

void ClientNetwork::bend(Endpoint& from, Endpoint& to, std::vector<std::uint8_t>& datagram) {
    constexpr std::size_t number_at = 5;  // of a record of DTLS
    if (datagram.empty()) return;
    switch (recorder_.below(6)) {
        case 0:
            datagram.resize(recorder_.below(static_cast<std::uint32_t>(datagram.size())));
            break;
        case 1:
            datagram[recorder_.below(static_cast<std::uint32_t>(datagram.size()))] ^=
                static_cast<std::uint8_t>(1U << recorder_.below(8));
            break;
        case 2:
            if (datagram.size() < number_at + 6) break;
            datagram[number_at + recorder_.below(6)] = static_cast<std::uint8_t>(recorder_.next());
            break;
        case 3:
            std::swap(from, to);
            break;
        case 4:
            from.port = 6'666;
            break;
        default:
            break;  // as it was
    }
}

}  // namespace romano::sim
