#include "overlay/cluster/replication/interest.h"

#include <algorithm>

namespace romano::cluster {

void Interest::on_event(BrokerId peer, const broker::LogEvent& event) {
    if (const auto* subscribed = std::get_if<broker::Subscribed>(&event)) {
        add(peer, subscribed->client_id, subscribed->subscription.filter);
    } else if (const auto* unsubscribed = std::get_if<broker::Unsubscribed>(&event)) {
        const auto session = filters_[peer].find(unsubscribed->client_id);
        if (session != filters_[peer].end() && session->second.erase(unsubscribed->filter) != 0) {
            remove(peer, unsubscribed->filter);
        }
    } else if (const auto* put_event = std::get_if<broker::SessionPut>(&event)) {
        put(peer, put_event->image);
    } else if (const broker::ClientId* left = broker::leaver(event)) {
        remove_session(peer, *left);
    }
}

void Interest::reset(BrokerId peer, const broker::Mirror& sessions) {
    forget(peer);
    sessions.visit([&](const broker::SessionImage& image) { put(peer, image); });
}

void Interest::forget(BrokerId peer) {
    const auto known = filters_.extract(peer);
    if (known.empty()) return;
    for (const auto& [client, filters] : known.mapped()) {
        for (const auto& filter : filters) remove(peer, filter);
    }
}

bool Interest::wants(std::string_view topic) const {
    bool somebody = false;
    tree_.match(topic, [&somebody](BrokerId, std::uint32_t) { somebody = true; });
    return somebody;
}

std::vector<BrokerId> Interest::interested_in(std::string_view topic) const {
    std::vector<BrokerId> peers;
    tree_.match(topic, [&peers](BrokerId peer, std::uint32_t) { peers.push_back(peer); });
    std::ranges::sort(peers);
    peers.erase(std::unique(peers.begin(), peers.end()), peers.end());
    return peers;
}

void Interest::add(BrokerId peer, const broker::ClientId& client, const std::string& filter) {
    if (!filters_[peer][client].insert(filter).second) return;
    if (std::uint32_t* count = tree_.find(filter, peer)) {
        ++*count;
    } else {
        tree_.put(filter, peer, 1);
    }
}

void Interest::remove(BrokerId peer, const std::string& filter) {
    std::uint32_t* count = tree_.find(filter, peer);
    if (count != nullptr && --*count == 0) tree_.remove(filter, peer);
}

void Interest::remove_session(BrokerId peer, const broker::ClientId& client) {
    const auto session = filters_[peer].extract(client);
    if (session.empty()) return;
    for (const auto& filter : session.mapped()) remove(peer, filter);
}

void Interest::put(BrokerId peer, const broker::SessionImage& image) {
    remove_session(peer, image.header.client_id);
    for (const auto& subscription : image.subscriptions) {
        add(peer, image.header.client_id, subscription.filter);
    }
}

}  // namespace romano::cluster
