#include "broker/core/publish_flow.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "broker/core/session_deadline.h"
#include "romano/base/bytes.h"
#include "romano/mqttsn/topic.h"

namespace romano::broker {

using mqttsn::MsgId;
using mqttsn::Qos;
using mqttsn::ReturnCode;
using mqttsn::TopicIdType;

std::string_view PublishFlow::name_of(Session* session, const mqttsn::Publish& message) {
    switch (message.topic_type) {
        case TopicIdType::normal: {
            const auto* topic = session == nullptr ? nullptr : session->topics.at(message.topic);
            if (topic == nullptr) return {};
            name_ = topic->name;  // the registry may grow while the message is handed on
            return name_;
        }
        case TopicIdType::predefined: {
            const auto& predefined = tables_.options.predefined_topics;
            const auto found = predefined.find(message.topic);
            return found == predefined.end() ? std::string_view{} : found->second;
        }
        case TopicIdType::short_name: {
            const auto octets = static_cast<std::uint16_t>(message.topic);
            name_ = {static_cast<char>(octets >> 8U), static_cast<char>(octets & 0xFFU)};
            return name_;
        }
        case TopicIdType::reserved:
            break;
    }
    return {};
}

/// Whether the message can be accepted; a refusal is counted.
ReturnCode PublishFlow::judge(const mqttsn::Publish& message, std::string_view topic) {
    const auto refused = [this](Drop reason, ReturnCode code) {
        tables_.count(reason);
        return code;
    };
    if (message.topic_type == TopicIdType::reserved) {
        return refused(Drop::invalid_topic, ReturnCode::not_supported);
    }
    if (topic.empty()) return refused(Drop::invalid_topic, ReturnCode::invalid_topic_id);
    const bool has_id =
        message.topic_type == TopicIdType::predefined ||
        (message.topic_type == TopicIdType::normal && message.qos != Qos::without_connection);
    const bool valid = has_id || mqttsn::is_valid_topic_name(topic);  // checked when it got the id
    // Where nobody is asked for permission, nobody publishes there.
    const bool is_open = tables_.permissions != nullptr && topic == tables_.options.open_topic;
    if (!valid || (topic.starts_with('$') && !is_open)) {
        return refused(Drop::invalid_topic, ReturnCode::not_supported);
    }
    if (message.data.size() > tables_.limits().payload_octets) {
        return refused(Drop::too_large, ReturnCode::not_supported);
    }
    const bool promises = message.qos == Qos::at_least_once || message.qos == Qos::exactly_once;
    const auto never_retained = tables_.options.never_retained;
    const bool is_kept = message.retain && !message.data.empty() &&
                         (never_retained == nullptr || !never_retained(topic, message.data));
    const bool deletes = message.retain && message.data.empty();
    if ((promises && tables_.congested) || ((promises || is_kept) && tables_.full && !deletes) ||
        (is_kept && !tables_.retained.has_room(topic))) {
        return refused(Drop::no_room, ReturnCode::congestion);
    }
    return ReturnCode::accepted;
}

void PublishFlow::on_publish(Session& session, const mqttsn::Publish& message, Turn& turn) {
    const bool promises = message.qos == Qos::at_least_once || message.qos == Qos::exactly_once;
    if (promises && session.late_answer.at != never) {
        const LateAnswer& owed = session.late_answer;
        if (owed.msg_id == message.msg_id && owed.qos == message.qos) return;  // it will come
        answer_what_is_owed(session, turn);
    }
    if (message.qos == Qos::exactly_once &&
        std::ranges::count(session.unreleased, message.msg_id) != 0) {
        outbox_.send(session, mqttsn::Pubrec{message.msg_id}, Gate::logged, turn);
        return;
    }
    const std::string_view topic = name_of(&session, message);
    ReturnCode code = judge(message, topic);
    if (code == ReturnCode::accepted &&
        !enforcement_.may_publish(speaker_of(session), topic, message.data, turn)) {
        code = ReturnCode::not_supported;
    }
    if (code != ReturnCode::accepted) {
        outbox_.send(session, mqttsn::Puback{message.topic, message.msg_id, code}, Gate::open,
                     turn);
        return;
    }
    const Publication publication =
        router_.admitted({topic, message.data, message.qos, message.retain});
    router_.find_receivers(publication, turn);
    const bool is_qos2 = message.qos == Qos::exactly_once;
    // A repetition waited long enough already, for the answer of a home that the client has left.
    const Duration delay = message.dup ? Duration{0} : delay_of(session, topic, turn.now);
    const LateAnswer answer{promises ? turn.now + delay : never, message.qos, message.topic,
                            message.msg_id};
    router_.accept(publication, is_qos2 ? &session : nullptr,
                   is_qos2 ? message.msg_id : mqttsn::no_msg_id, turn);
    if (is_qos2) remember_unreleased(session, message.msg_id, turn);
    if (answer.at <= turn.now) {
        say(session, answer, turn);
    } else if (promises) {
        ++tables_.counters.late_answers;
        session.late_answer = answer;
        schedule(tables_, session);
    }
    router_.deliver(publication, turn);
    observe(session, publication, turn);
}

/// How much later the publisher hears that its message was taken, by how full the fullest queue of
/// its receivers is: below half not at all. So publishers go at the pace of their receivers before
/// anything is lost.
Duration PublishFlow::delay_of(const Session& publisher, std::string_view topic,
                               Instant now) const {
    const std::size_t most = tables_.limits().queued_per_session;
    const std::size_t waiting = std::min(router_.longest_queue(publisher, topic, now), most);
    if (waiting <= tables_.limits().half_a_queue()) return Duration{0};
    const std::chrono::duration<double, std::milli> longest{tables_.limits().pacing_ms};
    const double above_half = static_cast<double>(2 * waiting - most) / static_cast<double>(most);
    return std::chrono::duration_cast<Duration>(longest * above_half);
}

void PublishFlow::say(Session& session, const LateAnswer& answer, Turn& turn) {
    if (answer.qos == Qos::exactly_once) {
        outbox_.send(session, mqttsn::Pubrec{answer.msg_id}, Gate::logged, turn);
    } else {
        outbox_.send(session, mqttsn::Puback{answer.topic, answer.msg_id, ReturnCode::accepted},
                     Gate::logged, turn);
    }
}

void PublishFlow::answer_what_is_owed(Session& session, Turn& turn) {
    const LateAnswer owed = std::exchange(session.late_answer, {});
    if (owed.at != never && session.reachable) say(session, owed, turn);
}

void PublishFlow::observe(const Session& session, const Publication& publication, Turn& turn) {
    if (std::ranges::count(tables_.options.observed_topics, publication.topic) == 0) return;
    turn.out.push(Observed{std::make_unique<Observation>(
        Observation{session.header.client_id,
                    std::string{publication.topic},
                    {publication.payload.begin(), publication.payload.end()}})});
}

/// A client has one exchange open (6.6c): what stands there for long was abandoned, and is the
/// first to go when there are too many.
void PublishFlow::remember_unreleased(Session& session, MsgId msg_id, Turn& turn) {
    session.unreleased.push_back(msg_id);
    session.header.last_published = session.header.last_heard;
    if (session.unreleased.size() <= tables_.limits().unreleased_per_session) return;
    const MsgId abandoned = session.unreleased.front();
    tables_.log.append(turn.out, [&] {
        return PublishReleased{session.header.client_id, abandoned};
    });
    session.unreleased.erase(session.unreleased.begin());
}

void PublishFlow::on_pubrel(Session& session, const mqttsn::Pubrel& message, Turn& turn) {
    session.header.last_published = session.header.last_heard;
    const auto found = std::ranges::find(session.unreleased, message.msg_id);
    if (found != session.unreleased.end()) {
        session.unreleased.erase(found);
        tables_.log.append(turn.out, [&] {
            return PublishReleased{session.header.client_id, message.msg_id};
        });
    }
    outbox_.send(session, mqttsn::Pubcomp{message.msg_id}, Gate::logged, turn);
}

void PublishFlow::on_connectionless(const Origin& origin, const mqttsn::Publish& message,
                                    Turn& turn) {
    mqttsn::Publish named = message;  // its data alone
    std::string_view topic;
    if (message.topic_type == TopicIdType::normal) {
        // RSMB's and Paho's own form: the id is the length of a name before the data (G19).
        const auto length = static_cast<std::size_t>(message.topic);
        if (length == 0 || length > message.data.size()) {
            tables_.count(Drop::invalid_topic);
            return;
        }
        topic = as_text(message.data.first(length));
        named.data = message.data.subspan(length);
    } else {
        topic = name_of(nullptr, message);
    }
    if (judge(named, topic) != ReturnCode::accepted) return;
    const Speaker speaker{origin.via, origin.from.wireless_node_id, {}};
    if (!enforcement_.may_publish(speaker, topic, named.data, turn)) return;
    router_.publish({topic, named.data, Qos::at_most_once, message.retain}, turn);
}

}  // namespace romano::broker
