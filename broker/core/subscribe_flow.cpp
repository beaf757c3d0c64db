#include "broker/core/subscribe_flow.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include "broker/core/cell.h"
#include "romano/base/bytes.h"
#include "romano/mqttsn/cell.h"
#include "romano/mqttsn/topic.h"

namespace romano::broker {

using mqttsn::Qos;
using mqttsn::ReturnCode;
using mqttsn::TopicId;
using mqttsn::TopicIdType;

namespace {

/// Levels of a filter. Each is a node of the tree of filters, many times as large as its octets,
/// and a step of its recursions: 32,000 of them in one datagram would be a stack overflow.
constexpr std::ptrdiff_t most_levels = 128;

bool is_too_deep(std::string_view filter) {
    return std::ranges::count(filter, '/') >= most_levels;
}

}  // namespace

void SubscribeFlow::on_register(Session& session, const mqttsn::Register& message, Turn& turn) {
    const auto answer = [&](TopicId id, ReturnCode code) {
        const Gate gate = code == ReturnCode::accepted ? Gate::logged : Gate::open;
        outbox_.send(session, mqttsn::Regack{id, message.msg_id, code}, gate, turn);
    };
    if (!mqttsn::is_valid_topic_name(message.topic_name)) {
        tables_.count(Drop::invalid_topic);
        answer(mqttsn::no_topic_id, ReturnCode::not_supported);
        return;
    }
    if (!enforcement_.may_register(speaker_of(session), message.topic_name, turn)) {
        answer(mqttsn::no_topic_id, ReturnCode::not_supported);
        return;
    }
    const TopicId id = subscriptions_.bind(session, message.topic_name, true, turn);
    if (id == mqttsn::no_topic_id) {
        tables_.count(Drop::no_room);
        answer(id, ReturnCode::congestion);
        return;
    }
    answer(id, ReturnCode::accepted);
}

Result<std::string_view, ReturnCode> SubscribeFlow::filter_of(const mqttsn::TopicRef& topic) const {
    if (topic.type == TopicIdType::predefined) {
        const auto found = tables_.options.predefined_topics.find(topic.id);
        if (found == tables_.options.predefined_topics.end()) return ReturnCode::invalid_topic_id;
        return std::string_view{found->second};
    }
    if (topic.type == TopicIdType::reserved || !mqttsn::is_valid_topic_filter(topic.name) ||
        is_too_deep(topic.name)) {
        return ReturnCode::not_supported;
    }
    return topic.name;
}

ReturnCode SubscribeFlow::judge(const Session& session, const mqttsn::Subscribe& message,
                                std::string_view filter) const {
    if (message.qos == Qos::without_connection) return ReturnCode::not_supported;
    if (filter == mqttsn::cell_topic && !can_listen(session)) return ReturnCode::not_supported;
    const bool full =
        tables_.full || session.subscriptions.size() >= tables_.limits().subscriptions_per_session;
    if (tables_.congested || (full && !subscriptions_.has(session, filter))) {
        return ReturnCode::congestion;
    }
    return ReturnCode::accepted;
}

void SubscribeFlow::refuse(Session& session, const mqttsn::Subscribe& message, ReturnCode code,
                           Turn& turn) {
    const TopicId id =
        message.topic.type == TopicIdType::predefined ? message.topic.id : mqttsn::no_topic_id;
    outbox_.send(session, mqttsn::Suback{Qos::at_most_once, id, message.msg_id, code}, Gate::open,
                 turn);
}

void SubscribeFlow::on_subscribe(Session& session, const mqttsn::Subscribe& message, Turn& turn) {
    const auto filter = filter_of(message.topic);
    const ReturnCode code = filter ? judge(session, message, *filter) : filter.error();
    if (code != ReturnCode::accepted) {
        tables_.count(code == ReturnCode::congestion ? Drop::no_room : Drop::invalid_topic);
        refuse(session, message, code, turn);
        return;
    }
    if (*filter != mqttsn::cell_topic &&  // it names no messages
        !enforcement_.may_subscribe(speaker_of(session), *filter, turn)) {
        refuse(session, message, ReturnCode::not_supported, turn);
        return;
    }
    Subscription subscription{.filter = std::string{*filter},
                              .type = message.topic.type,
                              .predefined_id = message.topic.id,
                              .granted = message.qos};
    TopicId id = mqttsn::no_topic_id;  // 6.9b: of a filter with wildcards
    if (message.topic.type == TopicIdType::predefined) {
        id = message.topic.id;
    } else if (!mqttsn::has_wildcard(*filter)) {
        if (message.topic.type == TopicIdType::short_name && filter->size() == 2) {
            id = TopicId{be16(as_octets(*filter), 0)};
        } else {
            id = subscriptions_.bind(session, *filter, true, turn);
            if (id == mqttsn::no_topic_id) {
                tables_.count(Drop::no_room);
                refuse(session, message, ReturnCode::congestion, turn);
                return;
            }
        }
    }
    session.topics.ask_again();
    subscriptions_.put(session, subscription, turn);
    outbox_.send(session, mqttsn::Suback{message.qos, id, message.msg_id, ReturnCode::accepted},
                 Gate::logged, turn);
    router_.send_retained(session, subscription, turn);
}

void SubscribeFlow::on_unsubscribe(Session& session, const mqttsn::Unsubscribe& message,
                                   Turn& turn) {
    const auto filter = filter_of(message.topic);
    if (!filter || !subscriptions_.remove(session, *filter, turn))
        tables_.count(Drop::invalid_topic);
    outbox_.send(session, mqttsn::Unsuback{message.msg_id}, Gate::logged, turn);
}

}  // namespace romano::broker
