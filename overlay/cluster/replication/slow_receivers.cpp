#include "overlay/cluster/replication/slow_receivers.h"

#include <algorithm>
#include <variant>

#include "romano/mqttsn/topic.h"

namespace romano::cluster {
namespace {

bool is_sent_messages(broker::SessionState state) {
    return state == broker::SessionState::active || state == broker::SessionState::awake;
}

/// While a topic is held up, what waits for that stands before what is on its way.
bool is_any_on_its_way(const broker::SessionImage& image) {
    return std::ranges::any_of(image.deliveries, [](const broker::Delivery& delivery) {
        return delivery.stage != broker::DeliveryStage::queued;
    });
}

}  // namespace

void SlowReceivers::on_event(Instant now, const broker::Mirror& sessions,
                             const broker::LogEvent& event, std::size_t many) {
    const BrokerId home = sessions.log().broker;
    const auto look = [&](const broker::ClientId& client) {
        const broker::SessionImage* image = sessions.session(client);
        if (image != nullptr) look_at(now, home, *image, many);
    };
    if (const auto* published = std::get_if<broker::Published>(&event)) {
        for (const auto& route : published->routes) look(route.client_id);
    } else if (const auto* routed = std::get_if<broker::Routed>(&event)) {
        for (const auto& route : routed->routes) look(route.client_id);
    } else if (const auto* ended = std::get_if<broker::DeliveryEnded>(&event)) {
        const auto receiver = receivers_.find(ended->client_id);
        if (receiver == receivers_.end()) return;
        receiver->second.last_taken = now;
        look(ended->client_id);
    } else if (const auto* put = std::get_if<broker::SessionPut>(&event)) {
        const auto known = receivers_.find(put->image.header.client_id);
        if (known != receivers_.end()) known->second.home = home;
        look_at(now, home, put->image, many);
    } else if (const auto* changed = std::get_if<broker::SessionChanged>(&event)) {
        const bool is_slow = find(home, changed->header.client_id) != nullptr;
        if (is_slow && !is_sent_messages(changed->header.state)) forget(changed->header.client_id);
    } else if (const broker::ClientId* left = broker::leaver(event)) {
        if (find(home, *left) != nullptr) forget(*left);
    } else if (const auto* subscribed = std::get_if<broker::Subscribed>(&event)) {
        Receiver* receiver = find(home, subscribed->client_id);
        if (receiver != nullptr) receiver->wants(subscribed->subscription);
    } else if (const auto* unsubscribed = std::get_if<broker::Unsubscribed>(&event)) {
        Receiver* receiver = find(home, unsubscribed->client_id);
        if (receiver != nullptr) receiver->wants_no_more(unsubscribed->filter);
    }
}

/// As it is at a home, the only one or another one than it was known at.
void SlowReceivers::look_at(Instant now, BrokerId home, const broker::SessionImage& image,
                            std::size_t many) {
    const broker::ClientId& client = image.header.client_id;
    const bool is_slow = image.deliveries.size() > many && is_any_on_its_way(image);
    if (!is_slow) {
        if (find(home, client) != nullptr) forget(client);
        return;
    }
    auto receiver = receivers_.find(client);
    if (receiver == receivers_.end()) {
        make_room();
        receiver = receivers_.emplace(client, Receiver{.home = home, .last_taken = now}).first;
        for (const auto& subscription : image.subscriptions) receiver->second.wants(subscription);
    }
    receiver->second.home = home;
    receiver->second.waiting = image.deliveries.size();
}

/// Whoever took nothing for longest holds up nobody, most likely.
void SlowReceivers::make_room() {
    if (receivers_.size() < most_heeded) return;
    receivers_.erase(std::ranges::min_element(
        receivers_, {}, [](const auto& entry) { return entry.second.last_taken; }));
}

SlowReceivers::Receiver* SlowReceivers::find(BrokerId home, const broker::ClientId& client) {
    const auto found = receivers_.find(client);
    return found == receivers_.end() || found->second.home != home ? nullptr : &found->second;
}

void SlowReceivers::Receiver::wants(const broker::Subscription& subscription) {
    wants_no_more(subscription.filter);
    if (subscription.granted != mqttsn::Qos::at_most_once) filters.push_back(subscription.filter);
}

void SlowReceivers::forget(BrokerId home) {
    std::erase_if(receivers_, [&](const auto& entry) { return entry.second.home == home; });
}

std::size_t SlowReceivers::longest_queue(std::string_view topic, Instant since) const {
    std::size_t most = 0;
    for (const auto& [client, receiver] : receivers_) {
        if (receiver.waiting <= most || receiver.last_taken < since) continue;
        const bool wants = std::ranges::any_of(
            receiver.filters, [&](const auto& filter) { return mqttsn::matches(filter, topic); });
        if (wants) most = receiver.waiting;
    }
    return most;
}

}  // namespace romano::cluster
