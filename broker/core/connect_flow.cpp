#include "broker/core/connect_flow.h"

#include <algorithm>
#include <utility>

#include "broker/core/session_deadline.h"
#include "broker/core/session_image_of.h"
#include "romano/mqttsn/cell.h"
#include "romano/mqttsn/topic.h"

namespace romano::broker {

using mqttsn::Qos;
using mqttsn::ReturnCode;

std::string ConnectFlow::client_id_of(const Origin& origin, const mqttsn::Connect& message) {
    if (!message.client_id.empty()) return std::string{message.client_id};
    std::string id = "@";
    const auto hex = [&id](unsigned octet) {
        constexpr std::string_view digits = "0123456789abcdef";
        id += digits[octet >> 4U & 0xFU];
        id += digits[octet & 0xFU];
    };
    const auto add = [&](const Endpoint& endpoint) {
        const std::size_t octets = endpoint.family == Endpoint::Family::ipv6 ? 16 : 4;
        for (std::size_t i = 0; i < octets; ++i) hex(endpoint.address[i]);
        id += ':';
        hex(endpoint.port >> 8U);
        hex(endpoint.port & 0xFFU);
    };
    add(origin.from.endpoint);
    if (!origin.from.wireless_node_id.empty()) id += '/';
    for (const char c : origin.from.wireless_node_id) hex(static_cast<unsigned char>(c));
    id += '>';
    add(origin.via);
    return id;
}

ReturnCode ConnectFlow::judge(const Origin& origin, const mqttsn::Connect& message) const {
    const bool is_owner = origin.from.endpoint == owner_endpoint;
    const bool is_for_owner =
        !message.client_id.empty() && message.client_id == tables_.options.read_by_owner;
    if (is_owner != is_for_owner || message.protocol_id != mqttsn::protocol_id ||
        message.client_id.size() > tables_.limits().client_id_octets ||
        (message.client_id.empty() && !message.clean_session)) {
        return ReturnCode::not_supported;
    }
    const bool brings_more =
        message.will || tables_.sessions.find(client_id_of(origin, message)) == nullptr;
    return tables_.congested || (tables_.full && brings_more) ? ReturnCode::congestion
                                                              : ReturnCode::accepted;
}

bool ConnectFlow::is_repetition(const Origin& origin, const mqttsn::Connect& message,
                                std::string_view client_id) const {
    const Session* session = tables_.sessions.find(client_id);
    return session != nullptr && session->fresh && session->reachable && !message.will &&
           !session->fresh_will && session->header.state == SessionState::active &&
           session->is_at(origin) && session->header.clean == message.clean_session &&
           session->header.keep_alive_s == message.duration_s;
}

void ConnectFlow::on_connect(const Origin& origin, const mqttsn::Connect& message, Turn& turn) {
    Prompt prompt{.client_id = client_id_of(origin, message),
                  .clean = message.clean_session,
                  .keep_alive_s = message.duration_s,
                  .refusal = judge(origin, message),
                  .will = {},
                  .since = turn.now};
    if (prompt.refusal == ReturnCode::accepted &&
        is_repetition(origin, message, prompt.client_id)) {
        Session& session = *tables_.sessions.find(prompt.client_id);
        session.heard_at = turn.now;
        outbox_.send(session, mqttsn::Connack{ReturnCode::accepted}, Gate::logged, turn);
        return;
    }
    if (!message.will) {
        prompts_.erase(origin);
        finish(origin, prompt, WillAnswer::none, turn);
        return;
    }
    if (prompt.refusal != ReturnCode::accepted) prompt.client_id.clear();  // may be long
    const bool is_asked_again = prompts_.contains(origin);
    if (prompts_.size() >= tables_.limits().connecting && !is_asked_again) {
        refuse(origin, ReturnCode::congestion, turn);
        return;
    }
    prompts_.insert_or_assign(origin, std::move(prompt));
    if (sweep_at_ == never) sweep_at_ = turn.now + tables_.options.t_retry;
    if (is_asked_again && !may_answer(origin, turn)) return;
    outbox_.answer(origin.via, origin.from, mqttsn::Willtopicreq{}, turn);
}

void ConnectFlow::on_willtopic(const Origin& origin, const mqttsn::Willtopic& message, Turn& turn) {
    const auto found = prompts_.find(origin);
    if (found == prompts_.end()) {
        tables_.count(Drop::unexpected);
        return;
    }
    Prompt& prompt = found->second;
    prompt.since = turn.now;
    if (message.topic.empty()) {  // no will after all (6.3a)
        const Prompt done = std::move(prompt);
        prompts_.erase(found);
        finish(origin, done, WillAnswer::keeps_none, turn);
        return;
    }
    const bool is_asked_again = std::exchange(prompt.has_topic, true);
    if (message.qos == Qos::without_connection || !mqttsn::is_valid_topic_name(message.topic) ||
        message.topic.starts_with('$')) {
        prompt.refusal = ReturnCode::not_supported;
    }
    const Speaker speaker{origin.via, origin.from.wireless_node_id, prompt.client_id};
    if (prompt.refusal == ReturnCode::accepted &&
        !enforcement_.may_make_will(speaker, message.topic, turn)) {
        prompt.refusal = ReturnCode::not_supported;
    }
    if (prompt.refusal == ReturnCode::accepted) {
        prompt.will = {std::string{message.topic}, {}, message.qos, message.retain};
    }
    if (is_asked_again && !may_answer(origin, turn)) return;
    outbox_.answer(origin.via, origin.from, mqttsn::Willmsgreq{}, turn);
}

void ConnectFlow::on_willmsg(const Origin& origin, const mqttsn::Willmsg& message, Turn& turn) {
    const auto found = prompts_.find(origin);
    if (found != prompts_.end() && found->second.has_topic) {
        Prompt prompt = std::move(found->second);
        prompts_.erase(found);
        prompt.will.message.assign(message.message.begin(), message.message.end());
        if (message.message.size() > tables_.limits().payload_octets) {
            prompt.refusal = ReturnCode::not_supported;
        }
        finish(origin, prompt, WillAnswer::given, turn);
        return;
    }
    Session* session = tables_.sessions.find(origin);
    if (session != nullptr && session->fresh_will) {  // a repetition (6.2d)
        session->heard_at = turn.now;
        outbox_.send(*session, mqttsn::Connack{ReturnCode::accepted}, Gate::logged, turn);
        return;
    }
    tables_.count(Drop::unexpected);
}

void ConnectFlow::finish(const Origin& origin, const Prompt& prompt, WillAnswer answer,
                         Turn& turn) {
    if (prompt.refusal == ReturnCode::accepted) {
        accept(origin, prompt, answer, turn);
    } else {
        refuse(origin, prompt.refusal, turn);
    }
}

void ConnectFlow::refuse(const Origin& origin, ReturnCode why, Turn& turn) {
    if (!may_answer(origin, turn)) return;
    tables_.count(why == ReturnCode::congestion ? Drop::no_room : Drop::unexpected);
    outbox_.answer(origin.via, origin.from, mqttsn::Connack{why}, turn);
}

bool ConnectFlow::may_answer(const Origin& origin, Turn& turn) {
    if (has_key(origin) || answers_.allows(turn.now)) return true;
    tables_.count(Drop::stranger_rate);
    return false;
}

void ConnectFlow::accept(const Origin& origin, const Prompt& prompt, WillAnswer answer,
                         Turn& turn) {
    Session* session = tables_.sessions.find(prompt.client_id);
    const bool is_new = session == nullptr;
    if (is_new) session = lifecycle_.create(prompt.client_id, turn);
    if (session == nullptr) {
        refuse(origin, ReturnCode::congestion, turn);
        return;
    }
    tables_.sessions.come_back(*session);
    lifecycle_.move(*session, origin, turn);
    SessionHeader& header = session->header;
    if (std::exchange(header.provisional, false)) ++header.epoch;
    header.state = SessionState::active;
    header.clean = prompt.clean;
    header.keep_alive_s = prompt.keep_alive_s;
    header.sleep_s = 0;
    header.last_heard = tables_.clock.stamp(turn.now);
    header.departed = {};
    session->heard_at = turn.now;
    session->probe_at = never;
    session->exchange = {};
    session->late_answer = {};  // its client may use that msg id for another message
    session->pauses.clear();
    if (prompt.clean) {
        lifecycle_.wipe(*session);
        header.last_published = header.last_heard;  // what it had begun has ended
    }
    // Only a stranger's kept session may be with a home that is out of sight.
    if (prompt.clean || !is_new) {
        header.epoch = std::max(header.epoch + 1, header.last_heard.value);
    }

    if (prompt.clean || is_new) {
        if (answer == WillAnswer::given) session->will = prompt.will;
        tables_.log.append(turn.out, [&] { return SessionPut{bare_image_of(*session)}; });
    } else {
        session->topics.forget_known();
        subscriptions_.remove(*session, mqttsn::cell_topic, turn);  // it says so anew (cell.h)
        lifecycle_.log_header(*session, turn, true);
        if (answer == WillAnswer::given) set_will(*session, prompt.will, turn);
        if (answer == WillAnswer::keeps_none) set_will(*session, std::nullopt, turn);
    }
    outbox_.send(*session, mqttsn::Connack{ReturnCode::accepted}, Gate::logged, turn);
    session->fresh = true;
    session->fresh_will = answer == WillAnswer::given;
    schedule(tables_, *session);
    deliveries_.go_on(*session, turn);
}

void ConnectFlow::on_willtopicupd(Session& session, const mqttsn::Willtopicupd& message,
                                  Turn& turn) {
    const bool deletes = message.topic.empty();  // topic and message (6.4b)
    if (!deletes &&
        (message.qos == Qos::without_connection || !mqttsn::is_valid_topic_name(message.topic) ||
         message.topic.starts_with('$'))) {
        tables_.count(Drop::invalid_topic);
        outbox_.send(session, mqttsn::Willtopicresp{ReturnCode::not_supported}, Gate::open, turn);
        return;
    }
    if (!deletes && !enforcement_.may_make_will(speaker_of(session), message.topic, turn)) {
        outbox_.send(session, mqttsn::Willtopicresp{ReturnCode::not_supported}, Gate::open, turn);
        return;
    }
    if (!deletes && (tables_.congested || tables_.full)) {
        tables_.count(Drop::no_room);
        outbox_.send(session, mqttsn::Willtopicresp{ReturnCode::congestion}, Gate::open, turn);
        return;
    }
    if (deletes) {
        set_will(session, std::nullopt, turn);
    } else {
        Will will = session.will.value_or(Will{});
        will.topic = message.topic;
        will.qos = message.qos;
        will.retain = message.retain;
        set_will(session, std::move(will), turn);
    }
    outbox_.send(session, mqttsn::Willtopicresp{ReturnCode::accepted}, Gate::logged, turn);
}

void ConnectFlow::on_willmsgupd(Session& session, const mqttsn::Willmsgupd& message, Turn& turn) {
    if (message.message.size() > tables_.limits().payload_octets) {
        tables_.count(Drop::too_large);
        outbox_.send(session, mqttsn::Willmsgresp{ReturnCode::not_supported}, Gate::open, turn);
        return;
    }
    if (tables_.congested || tables_.full) {
        tables_.count(Drop::no_room);
        outbox_.send(session, mqttsn::Willmsgresp{ReturnCode::congestion}, Gate::open, turn);
        return;
    }
    Will will = session.will.value_or(Will{});
    will.message.assign(message.message.begin(), message.message.end());
    set_will(session, std::move(will), turn);
    outbox_.send(session, mqttsn::Willmsgresp{ReturnCode::accepted}, Gate::logged, turn);
}

void ConnectFlow::set_will(Session& session, std::optional<Will> will, Turn& turn) {
    if (session.will == will) return;
    session.will = std::move(will);
    tables_.log.append(turn.out, [&] {
        return WillChanged{session.header.client_id, session.will};
    });
}

void ConnectFlow::on_tick(Instant now) {
    if (now < sweep_at_) return;
    const Duration patience = tables_.options.t_retry * (1 + tables_.options.n_retry);
    std::erase_if(prompts_,
                  [&](const auto& entry) { return entry.second.since + patience <= now; });
    sweep_at_ = prompts_.empty() ? never : now + tables_.options.t_retry;
}

}  // namespace romano::broker
