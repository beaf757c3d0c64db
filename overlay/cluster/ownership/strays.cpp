#include "overlay/cluster/ownership/strays.h"

#include <utility>

namespace romano::cluster {

void Strays::carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                      const View& view, ServiceAddresses& addresses, Departures& departures,
                      const std::set<Endpoint>& half_adopted) {
    const LogPosition own_end{logs.own.id(), effects.broker.last_seq()};
    for (const Endpoint& address : std::set{addresses.adopted()}) {
        if (addresses.is_taking(address) || half_adopted.contains(address)) continue;
        if (addresses.is_serving(address) || addresses.is_home(address)) {
            addresses.forget_adopted(address);  // they are where they belong
            continue;
        }
        const auto server = membership.server_of(address, view, [&](const Peer& peer) {
            return peer.speaks_at(address) && peer.beacon.hears_from(own_end.log.broker) &&
                   peer.follows(own_end);
        });
        if (!server || !move_some(effects, address, *server, logs, departures)) continue;
        addresses.forget_adopted(address);
    }
}

bool Strays::move_some(Effects& effects, const Endpoint& address, const LogId& server,
                       const Logs& logs, Departures& departures) {
    if (departures.to(server) > sessions_per_turn_) return false;
    auto& waiting = waiting_[address];
    if (waiting.empty()) {
        if (departures.has_any_via(address)) return false;  // they may come back
        waiting = effects.broker.client_ids_via(address);
        if (waiting.empty()) {
            waiting_.erase(address);
            return true;
        }
    }
    for (std::size_t allowed = sessions_per_turn_; allowed > 0 && !waiting.empty(); --allowed) {
        const broker::ClientId client = std::move(waiting.back());
        waiting.pop_back();
        const broker::SessionHeader* header = effects.broker.header(client);
        if (header == nullptr || header->via != address) continue;  // it spoke, and was fetched
        departures.move(effects, client, server, 0, logs.peers);
    }
    return false;
}

}  // namespace romano::cluster
