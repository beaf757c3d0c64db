#include "overlay/cluster/ownership/adoption.h"

#include <algorithm>
#include <utility>

namespace romano::cluster {
namespace {

/// A mirror knows queued messages by position; what it has not seen itself may be here.
void find_missing_messages(broker::SessionImage& image, const Effects& effects, const Logs& logs) {
    for (broker::Delivery& delivery : image.deliveries) {
        if (delivery.message) continue;
        delivery.message = logs.publish_at(delivery.position);
        if (!delivery.message) delivery.message = effects.broker.retained_at(delivery.position);
    }
}

}  // namespace

const LogHistory* Logs::history_of(const LogId& log) const {
    if (log == own.id()) return &own.history();
    const auto peer = peers.find(log);
    return peer == peers.end() ? nullptr : &peer->second.history();
}

MessagePtr Logs::publish_at(const LogPosition& position) const {
    if (position.log == own.id()) return own.history().publish_at(position.seq);
    const auto peer = peers.find(position.log);
    return peer == peers.end() ? MessagePtr{} : peer->second.publish_at(position.seq);
}

std::vector<MessagePtr> missed_publishes(const broker::SessionImage& image,
                                         const broker::BrokerCore& broker, const Logs& logs) {
    std::vector<MessagePtr> missed;
    const auto take = [&](std::vector<MessagePtr> publishes, Seq through) {
        while (!publishes.empty() && publishes.back()->position.seq > through) publishes.pop_back();
        const auto middle = static_cast<std::ptrdiff_t>(missed.size());
        missed.insert(missed.end(), publishes.begin(), publishes.end());
        std::inplace_merge(missed.begin(), missed.begin() + middle, missed.end(),
                           [](const MessagePtr& a, const MessagePtr& b) {
                               return a->published_at < b->published_at;
                           });
    };
    const LogId& self = logs.own.id();
    take(logs.own.history().publishes_after(worked_through(image, self)), logs.own.last());
    for (const auto& [id, log] : logs.peers) {
        take(log.publishes_after(worked_through(image, id)), broker.cursor(id));
    }
    return missed;
}

broker::SessionImage caught_up(const Effects& effects, const Logs& logs,
                               broker::SessionImage image) {
    find_missing_messages(image, effects, logs);
    const auto missed = missed_publishes(image, effects.broker, logs);
    return effects.broker.caught_up(std::move(image), missed);
}

void adopt(Effects& effects, const Logs& logs, broker::SessionImage image,
           const std::optional<LogPosition>& moved, std::optional<broker::SessionImage> ours) {
    if (ours) ours = caught_up(effects, logs, *std::move(ours));
    find_missing_messages(image, effects, logs);
    auto missed = missed_publishes(image, effects.broker, logs);
    effects.broker.adopt(effects.now, std::move(image), std::move(missed), effects.clients, moved,
                         std::move(ours));
}

}  // namespace romano::cluster
