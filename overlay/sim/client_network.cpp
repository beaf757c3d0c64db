#include "overlay/sim/client_network.h"

#include <algorithm>
#include <utility>

namespace romano::sim {

ClientNetwork::Binding ClientNetwork::bind(const Endpoint& address, Node node, Receiver receiver) {
    const Binding id{++last_binding_};
    bound_[address].push_back({id, node, std::move(receiver)});
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
    const bool dropped =
        (filter_ && filter_(from, to, datagram)) || random_.happens(quality_.loss_ppm);
    trace_.note(events_.now(), from, dropped ? "-x" : "->", to, datagram);
    if (dropped) return;
    const int copies = random_.happens(quality_.duplication_ppm) ? 2 : 1;
    Instant arrival = events_.now() + quality_.delay(random_);
    if (!quality_.overtaking) {
        Instant& last = last_arrival_[{from, to}];
        arrival = last = std::max(last, arrival);
    }
    events_.at(arrival, [this, sender, from, to, copies,
                         octets = std::vector<std::uint8_t>(datagram.begin(), datagram.end())] {
        for (int i = 0; i < copies; ++i) arrive(sender, from, to, octets);
    });
}

void ClientNetwork::arrive(Node sender, const Endpoint& from, const Endpoint& to, Bytes datagram) {
    const auto found = bound_.find(to);
    if (found == bound_.end()) return;
    const auto newest =
        std::find_if(found->second.rbegin(), found->second.rend(),
                     [&](const Bound& bound) { return !cuts_.is_cut(sender, bound.node); });
    if (newest == found->second.rend()) {
        trace_.note(events_.now(), "nobody at", to);
        return;
    }
    const Receiver receiver = newest->receiver;  // may unbind itself
    receiver(to, from, datagram);
}

}  // namespace romano::sim
