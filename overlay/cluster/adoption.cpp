#include "overlay/cluster/adoption.h"

#include <algorithm>
#include <utility>

#include "romano/mqttsn/topic.h"

namespace romano::cluster {
namespace {

Seq worked_through(const broker::SessionImage& image, const LogId& log) {
    const auto found = std::ranges::find(image.worked_through, log, &LogPosition::log);
    return found == image.worked_through.end() ? 0 : found->seq;
}

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

void leave_out_delivered(broker::SessionImage& image, std::vector<MessagePtr>& missed,
                         const broker::SessionImage& former) {
    if (!broker::keeps_messages(former.header)) return;  // nothing was queued for it
    const auto is_delivered = [&](const MessagePtr& message) {
        const LogPosition& position = message->position;
        if (position.seq > worked_through(former, position.log)) return false;
        const bool was_queued =
            std::ranges::any_of(former.subscriptions, [&](const auto& subscription) {
                return subscription.granted != mqttsn::Qos::at_most_once &&
                       mqttsn::matches(subscription.filter, message->topic);
            });
        const bool still_waits =
            std::ranges::count(former.deliveries, position, &broker::Delivery::position) > 0;
        return was_queued && !still_waits;
    };
    std::erase_if(missed, is_delivered);
    // What the image's home had received: the client knows, and waits for its end.
    std::erase_if(image.deliveries, [&](const broker::Delivery& delivery) {
        return delivery.message && !delivery.retain &&
               delivery.stage != broker::DeliveryStage::released && is_delivered(delivery.message);
    });
}

broker::SessionImage caught_up(const Effects& effects, const Logs& logs,
                               broker::SessionImage image) {
    find_missing_messages(image, effects, logs);
    const auto missed = missed_publishes(image, effects.broker, logs);
    return effects.broker.caught_up(std::move(image), missed);
}

bool adopt(Effects& effects, const Logs& logs, broker::SessionImage image) {
    find_missing_messages(image, effects, logs);
    auto missed = missed_publishes(image, effects.broker, logs);
    if (const auto own = effects.broker.image(image.header.client_id)) {
        leave_out_delivered(image, missed, *own);
    }
    return effects.broker.adopt(effects.now, std::move(image), missed, effects.clients);
}

}  // namespace romano::cluster
