#include "broker/core/mirror.h"

#include <algorithm>
#include <cassert>
#include <utility>
#include <variant>

namespace romano::broker {
namespace {

/// The first: a home works on its queue in order, and so does its mirror.
std::vector<Delivery>::iterator delivery_at(SessionImage& image, const LogPosition& position) {
    return std::ranges::find(image.deliveries, position, &Delivery::position);
}

}  // namespace

void Mirror::begin_after(Seq as_of, std::span<const LogPosition> cursors) {
    applied_ = as_of;
    for (const LogPosition& position : cursors) cursors_.advance(position);
}

void Mirror::apply(Seq seq, const LogEvent& event) {
    assert(seq == applied_ + 1);
    applied_ = seq;
    std::visit([this](const auto& e) { on(e); }, event);
}

SessionImage* Mirror::find(std::string_view client_id) {
    const auto found = sessions_.find(client_id);
    return found == sessions_.end() ? nullptr : &found->second;
}

void Mirror::put(const SessionImage& image) {
    erase(image.header.client_id);
    for (const Delivery& delivery : image.deliveries) {
        if (!delivery.message) waiting_[delivery.position].push_back(image.header.client_id);
    }
    sessions_.emplace(image.header.client_id, image);
}

void Mirror::erase(std::string_view client_id) {
    const auto found = sessions_.find(client_id);
    if (found == sessions_.end()) return;
    for (const Delivery& delivery : found->second.deliveries) {
        if (delivery.message) continue;
        const auto waiting = waiting_.find(delivery.position);
        if (waiting == waiting_.end()) continue;
        std::erase(waiting->second, client_id);
        if (waiting->second.empty()) waiting_.erase(waiting);
    }
    sessions_.erase(found);
}

void Mirror::on(const SessionPut& event) {
    put(event.image);
}

void Mirror::on(const SessionChanged& event) {
    SessionImage* image = find(event.header.client_id);
    if (image == nullptr) return;
    image->header = event.header;
    if (!event.forgets_topics) return;
    for (TopicBinding& topic : image->topics) topic.known_to_client = false;
}

void Mirror::on(const SessionErased& event) {
    erase(event.client_id);
}

void Mirror::on(const SessionMoved& event) {
    erase(event.header.client_id);
}

void Mirror::on(const WillChanged& event) {
    if (SessionImage* image = find(event.client_id)) image->will = event.will;
}

void Mirror::on(const Subscribed& event) {
    SessionImage* image = find(event.client_id);
    if (image == nullptr) return;
    const auto same =
        std::ranges::find(image->subscriptions, event.subscription.filter, &Subscription::filter);
    if (same != image->subscriptions.end()) {
        *same = event.subscription;
    } else {
        image->subscriptions.push_back(event.subscription);
    }
}

void Mirror::on(const Unsubscribed& event) {
    SessionImage* image = find(event.client_id);
    if (image == nullptr) return;
    std::erase_if(image->subscriptions,
                  [&](const Subscription& s) { return s.filter == event.filter; });
}

void Mirror::on(const TopicBound& event) {
    SessionImage* image = find(event.client_id);
    if (image == nullptr) return;
    // Ids count upward: a new one belongs at the end, a known one is found by halving.
    const auto at =
        std::ranges::lower_bound(image->topics, event.binding.id, {}, &TopicBinding::id);
    if (at != image->topics.end() && at->id == event.binding.id) {
        *at = event.binding;
    } else {
        image->topics.insert(at, event.binding);
    }
}

void Mirror::on(const Published& event) {
    if (!event.publisher.empty()) {
        if (SessionImage* image = find(event.publisher)) {
            image->unreleased.push_back(event.msg_id);
            SessionHeader& header = image->header;
            header.last_published = event.message->published_at;
            header.last_heard = std::max(header.last_heard, header.last_published);
        }
    }
    if (!event.will_of.empty()) {
        if (SessionImage* image = find(event.will_of)) {
            image->header.state = SessionState::lost;
            image->header.departed = event.message->published_at;
        }
    }
    for (const Route& route : event.routes) queue({log_, applied_}, event.message, route);
    if (!waiting_.empty()) resolve(event.message);
}

void Mirror::on(const Routed& event) {
    bool live = true;
    for (const Route& route : event.routes) {
        queue(event.message, {}, route);
        live = live && !route.retain;
    }
    if (live && event.message.log != log_) cursors_.advance(event.message);
}

void Mirror::queue(const LogPosition& position, const MessagePtr& message, const Route& route) {
    SessionImage* image = find(route.client_id);
    if (image == nullptr) return;
    image->deliveries.push_back(
        {.position = position, .message = message, .qos = route.qos, .retain = route.retain});
    if (!message) waiting_[position].push_back(route.client_id);
}

void Mirror::on(const Cursor& event) {
    for (const LogPosition& through : event.through) cursors_.advance(through);
}

void Mirror::on(const DeliveryStarted& event) {
    SessionImage* image = find(event.client_id);
    if (image == nullptr) return;
    const auto delivery = delivery_at(*image, event.message);
    if (delivery == image->deliveries.end()) return;
    delivery->stage = DeliveryStage::published;
    delivery->msg_id = image->last_msg_id = event.msg_id;
    delivery->qos = event.qos;
}

void Mirror::on(const DeliveryReleased& event) {
    SessionImage* image = find(event.client_id);
    if (image == nullptr) return;
    const auto delivery = delivery_at(*image, event.message);
    if (delivery != image->deliveries.end()) delivery->stage = DeliveryStage::released;
}

void Mirror::on(const DeliveryEnded& event) {
    SessionImage* image = find(event.client_id);
    if (image == nullptr) return;
    const auto delivery = delivery_at(*image, event.message);
    if (delivery == image->deliveries.end()) return;
    if (!delivery->message) {
        const auto waiting = waiting_.find(event.message);
        if (waiting != waiting_.end()) {
            const auto one = std::ranges::find(waiting->second, event.client_id);
            if (one != waiting->second.end()) waiting->second.erase(one);
            if (waiting->second.empty()) waiting_.erase(waiting);
        }
    }
    image->deliveries.erase(delivery);
}

void Mirror::on(const PublishReleased& event) {
    SessionImage* image = find(event.client_id);
    if (image == nullptr) return;
    const auto found = std::ranges::find(image->unreleased, event.msg_id);
    if (found != image->unreleased.end()) image->unreleased.erase(found);
}

void Mirror::resolve(const MessagePtr& message) {
    const auto waiting = waiting_.find(message->position);
    if (waiting == waiting_.end()) return;
    for (const ClientId& client_id : waiting->second) {
        SessionImage* image = find(client_id);
        if (image == nullptr) continue;
        for (Delivery& delivery : image->deliveries) {
            if (delivery.position == message->position) delivery.message = message;
        }
    }
    waiting_.erase(waiting);
}

std::vector<LogPosition> Mirror::unresolved() const {
    std::vector<LogPosition> positions;
    for (const auto& [position, clients] : waiting_) positions.push_back(position);
    std::ranges::sort(positions);
    return positions;
}

bool Mirror::contains(std::string_view client_id) const {
    return sessions_.find(client_id) != sessions_.end();
}

const SessionHeader* Mirror::header(std::string_view client_id) const {
    const SessionImage* image = session(client_id);
    return image == nullptr ? nullptr : &image->header;
}

const SessionImage* Mirror::session(std::string_view client_id) const {
    const auto found = sessions_.find(client_id);
    return found == sessions_.end() ? nullptr : &found->second;
}

SessionImage Mirror::completed(const SessionImage& image) const {
    SessionImage whole = image;
    std::vector<LogPosition> home = cursors_.all();
    if (applied_ != 0) home.push_back({log_, applied_});
    whole.worked_through = later_of(home, image.worked_through);
    return whole;
}

std::optional<SessionImage> Mirror::image(std::string_view client_id) const {
    const auto found = sessions_.find(client_id);
    if (found == sessions_.end()) return std::nullopt;
    return completed(found->second);
}

std::vector<SessionImage> Mirror::images() const {
    std::vector<SessionImage> all;
    all.reserve(sessions_.size());
    for (const auto& [client_id, image] : sessions_) all.push_back(completed(image));
    std::ranges::sort(all, {}, [](const SessionImage& image) -> const ClientId& {
        return image.header.client_id;
    });
    return all;
}

}  // namespace romano::broker
