#include "overlay/cluster/replication/interest.h"

#include <algorithm>
#include <limits>

namespace romano::cluster {
namespace {

constexpr std::size_t filters_per_turn = 512;

bool has(const broker::SessionImage& session, const std::string& filter) {
    return std::ranges::count(session.subscriptions, filter, &broker::Subscription::filter) > 0;
}

}  // namespace

void Interest::on_event(const broker::Mirror& sessions, const broker::LogEvent& event) {
    const BrokerId peer = sessions.log().broker;
    const auto remove_known = [&](const broker::ClientId& client) {
        if (const auto* session = sessions.session(client)) remove(peer, *session);
    };
    if (const auto* subscribed = std::get_if<broker::Subscribed>(&event)) {
        const auto* session = sessions.session(subscribed->client_id);
        const std::string& filter = subscribed->subscription.filter;
        if (session != nullptr && !has(*session, filter)) add(peer, filter);
    } else if (const auto* unsubscribed = std::get_if<broker::Unsubscribed>(&event)) {
        const auto* session = sessions.session(unsubscribed->client_id);
        const std::string& filter = unsubscribed->filter;
        if (session != nullptr && has(*session, filter)) remove(peer, filter);
    } else if (const auto* put = std::get_if<broker::SessionPut>(&event)) {
        remove_known(put->image.header.client_id);
        add(peer, put->image);
    } else if (const broker::ClientId* left = broker::leaver(event)) {
        remove_known(*left);
    }
}

void Interest::reset(const broker::Mirror& sessions) {
    const BrokerId peer = sessions.log().broker;
    forgotten_.erase(peer);
    if (peers_.erase(peer) != 0) tree_.remove_all(peer);
    sessions.visit([&](const broker::SessionImage& session) { add(peer, session); });
}

void Interest::forget(BrokerId peer) {
    if (peers_.contains(peer)) {
        forgotten_.try_emplace(peer, std::numeric_limits<std::size_t>::max());
    }
}

void Interest::on_turn() {
    for (auto at = forgotten_.begin(); at != forgotten_.end();) {
        const auto forgotten = at++;
        auto& [peer, left] = *forgotten;
        left = tree_.remove_some(peer, left, filters_per_turn);
        if (left > 0) continue;
        peers_.erase(peer);
        forgotten_.erase(forgotten);
    }
}

void Interest::add(BrokerId peer, const broker::SessionImage& session) {
    for (const auto& subscription : session.subscriptions) add(peer, subscription.filter);
}

void Interest::remove(BrokerId peer, const broker::SessionImage& session) {
    for (const auto& subscription : session.subscriptions) remove(peer, subscription.filter);
}

std::vector<BrokerId> Interest::interested_in(std::string_view topic) const {
    std::vector<BrokerId> peers;
    tree_.match(topic, [&peers](BrokerId peer, std::uint32_t) { peers.push_back(peer); });
    std::ranges::sort(peers);
    peers.erase(std::unique(peers.begin(), peers.end()), peers.end());
    return peers;
}

void Interest::add(BrokerId peer, const std::string& filter) {
    if (std::uint32_t* count = tree_.find(filter, peer)) {
        ++*count;
    } else {
        tree_.put(filter, peer, 1);
        peers_.insert(peer);
    }
}

void Interest::remove(BrokerId peer, const std::string& filter) {
    std::uint32_t* count = tree_.find(filter, peer);
    if (count != nullptr && --*count == 0) tree_.remove(filter, peer);
}

}  // namespace romano::cluster
