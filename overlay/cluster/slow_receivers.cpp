#include "overlay/cluster/slow_receivers.h"

#include <algorithm>
#include <variant>

#include "romano/mqttsn/topic.h"

namespace romano::cluster {
namespace {

/// Whose session an event changes otherwise than by a delivery; null: nobody's.
const broker::ClientId* changed_by(const broker::LogEvent& event) {
    using namespace broker;
    if (const auto* put = std::get_if<SessionPut>(&event)) return &put->image.header.client_id;
    if (const auto* changed = std::get_if<SessionChanged>(&event)) {
        return &changed->header.client_id;
    }
    if (const auto* erased = std::get_if<SessionErased>(&event)) return &erased->client_id;
    if (const auto* subscribed = std::get_if<Subscribed>(&event)) return &subscribed->client_id;
    if (const auto* unsubscribed = std::get_if<Unsubscribed>(&event)) {
        return &unsubscribed->client_id;
    }
    return nullptr;
}

}  // namespace

void SlowReceivers::on_event(Instant now, const broker::Mirror& sessions,
                             const broker::LogEvent& event, std::size_t many) {
    if (const auto* published = std::get_if<broker::Published>(&event)) {
        for (const auto& route : published->routes) look_at(now, sessions, route.client_id, many);
    } else if (const auto* routed = std::get_if<broker::Routed>(&event)) {
        for (const auto& route : routed->routes) look_at(now, sessions, route.client_id, many);
    } else if (const auto* ended = std::get_if<broker::DeliveryEnded>(&event)) {
        const auto peer = receivers_.find(sessions.log().broker);
        if (peer == receivers_.end()) return;
        const auto receiver = peer->second.find(ended->client_id);
        if (receiver == peer->second.end()) return;
        receiver->second.last_taken = now;
        look_at(now, sessions, ended->client_id, many);
    } else if (const auto* client = changed_by(event)) {
        forget(sessions.log().broker, *client);
    }
}

void SlowReceivers::look_at(Instant now, const broker::Mirror& sessions,
                            const broker::ClientId& client, std::size_t many) {
    const broker::SessionImage* image = sessions.session(client);
    const bool is_slow = image != nullptr && image->deliveries.size() > many &&
                         image->deliveries.front().stage != broker::DeliveryStage::queued;
    if (!is_slow) return forget(sessions.log().broker, client);
    Receivers& of_peer = receivers_[sessions.log().broker];
    auto receiver = of_peer.find(client);
    if (receiver == of_peer.end()) {
        if (of_peer.size() >= most_of_a_peer) return;
        receiver = of_peer.emplace(client, Receiver{.last_taken = now}).first;
        for (const auto& subscription : image->subscriptions) {
            if (subscription.granted == mqttsn::Qos::at_most_once) continue;
            receiver->second.filters.push_back(subscription.filter);
        }
    }
    receiver->second.waiting = image->deliveries.size();
}

void SlowReceivers::forget(BrokerId peer, const broker::ClientId& client) {
    const auto found = receivers_.find(peer);
    if (found == receivers_.end()) return;
    found->second.erase(client);
    if (found->second.empty()) receivers_.erase(found);
}

std::size_t SlowReceivers::longest_queue(std::string_view topic, Instant since) const {
    std::size_t most = 0;
    for (const auto& [peer, receivers] : receivers_) {
        for (const auto& [client, receiver] : receivers) {
            if (receiver.waiting <= most || receiver.last_taken < since) continue;
            const bool wants = std::ranges::any_of(receiver.filters, [&](const auto& filter) {
                return mqttsn::matches(filter, topic);
            });
            if (wants) most = receiver.waiting;
        }
    }
    return most;
}

}  // namespace romano::cluster
