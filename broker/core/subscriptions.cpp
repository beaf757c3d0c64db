#include "broker/core/subscriptions.h"

#include <algorithm>

#include "broker/core/enforcement.h"
#include "romano/base/bytes.h"
#include "romano/mqttsn/topic.h"

namespace romano::broker {

using mqttsn::TopicId;
using mqttsn::TopicIdType;

Grant Subscriptions::grant_of(const Session& session, const Subscription& subscription) const {
    Grant grant{subscription.granted, {subscription.type, mqttsn::no_topic_id}};
    const std::string& filter = subscription.filter;
    const Permissions* permissions = tables_.permissions;
    grant.is_partial = permissions != nullptr &&
                       permissions->may_read_of(speaker_of(session), filter) != Extent::all;
    if (subscription.type == TopicIdType::predefined) {
        grant.topic.id = subscription.predefined_id;
    } else if (mqttsn::has_wildcard(filter)) {
        grant.topic.type = TopicIdType::normal;
    } else if (subscription.type == TopicIdType::short_name && filter.size() == 2) {
        grant.topic.id = TopicId{be16(as_octets(filter), 0)};
    } else {
        grant.topic = {TopicIdType::normal, session.topics.find(filter)};
    }
    return grant;
}

void Subscriptions::put(Session& session, const Subscription& subscription, Turn& turn) {
    if (has(session, subscription.filter)) {
        *std::ranges::find(session.subscriptions, subscription.filter, &Subscription::filter) =
            subscription;
    } else {
        session.subscriptions.push_back(subscription);
    }
    tables_.subscribers.put(subscription.filter, session.number, grant_of(session, subscription));
    tables_.log.append(turn.out, [&] {
        return Subscribed{session.header.client_id, subscription};
    });
}

bool Subscriptions::remove(Session& session, std::string_view filter, Turn& turn) {
    if (!has(session, filter)) return false;
    const auto same = std::ranges::find(session.subscriptions, filter, &Subscription::filter);
    tables_.log.append(turn.out, [&] {
        return Unsubscribed{session.header.client_id, std::string{filter}};
    });
    tables_.subscribers.remove(filter, session.number);
    std::erase_if(session.retained_to_come,
                  [&](const RetainedToCome& rest) { return rest.subscription.filter == filter; });
    session.subscriptions.erase(same);
    return true;
}

bool Subscriptions::has(const Session& session, std::string_view filter) const {
    return tables_.subscribers.find(filter, session.number) != nullptr;
}

void Subscriptions::enter_all(const Session& session) {
    for (const Subscription& subscription : session.subscriptions) {
        tables_.subscribers.put(subscription.filter, session.number,
                                grant_of(session, subscription));
    }
}

void Subscriptions::leave_all(const Session& session) {
    for (const Subscription& subscription : session.subscriptions) {
        tables_.subscribers.remove(subscription.filter, session.number);
    }
}

TopicId Subscriptions::bind(Session& session, std::string_view name, bool known, Turn& turn) {
    TopicId id = session.topics.find(name);
    const bool is_new = id == mqttsn::no_topic_id;
    if (is_new) {
        const std::size_t most = tables_.limits().topics_per_session;
        if (tables_.full || session.topics.size() >= most) return id;
        id = session.topics.add(name);
        if (id == mqttsn::no_topic_id) return id;
    }
    TopicRegistry::Topic& topic = *session.topics.at(id);
    const bool becomes_known = known && !topic.known;
    if (known) topic.known = true, topic.refused = false;
    if (is_new || becomes_known) log_binding(session, id, topic, turn);
    return id;
}

void Subscriptions::set_known(Session& session, TopicId id, bool known, Turn& turn) {
    TopicRegistry::Topic* topic = session.topics.at(id);
    if (topic == nullptr || topic->known == known) return;
    topic->known = known;
    log_binding(session, id, *topic, turn);
}

void Subscriptions::log_binding(const Session& session, TopicId id,
                                const TopicRegistry::Topic& topic, Turn& turn) {
    tables_.log.append(turn.out, [&] {
        return TopicBound{session.header.client_id, {id, topic.name, topic.known}};
    });
}

}  // namespace romano::broker
