// Input to its exchange, and the operations in their turn. The exchanges themselves: see client.h.
#include "romano/client/client.h"

#include <algorithm>

#include "romano/mqttsn/decode.h"

namespace romano::client {

using mqttsn::MsgType;
using mqttsn::TopicIdType;

ClientCore::ClientCore(const Storage& storage, const Timing& timing, std::uint64_t seed)
    // A kept session may remember message ids of this client's earlier life; a random start makes
    // it unlikely to meet them.
    : last_msg_id_(static_cast<std::uint16_t>(Random{seed}.next())),
      operations_(storage.queue),
      timing_(timing),
      topics_(storage.topics, storage.names),
      unreleased_(storage.unreleased),
      datagram_octets_(storage.datagram_octets) {}

void ClientCore::on_datagram(Instant now, Bytes datagram, Output& out) {
    out.clear();
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return drop();
    // Whatever comes while awake shows that the broker is not done yet (6.14d).
    if (state_ == State::awake) exchange_.put_off(now, timing_.t_retry);
    dispatch(*frame, {now, out});
    carry_on({now, out});
}

void ClientCore::dispatch(const mqttsn::Frame& frame, const Call& call) {
    const Bytes body = frame.body;
    switch (frame.type) {
        case MsgType::connack:
            if (const auto m = mqttsn::decode_connack(body)) return on_connack(*m, call);
            break;
        case MsgType::willtopicreq:
            if (body.empty()) return on_will_prompt(ConnectStep::will_topic, call);
            break;
        case MsgType::willmsgreq:
            if (body.empty()) return on_will_prompt(ConnectStep::will_message, call);
            break;
        case MsgType::register_:
            if (const auto m = mqttsn::decode_register(body)) return on_register(*m, call.out);
            break;
        case MsgType::regack:
            if (const auto m = mqttsn::decode_regack(body)) return on_regack(*m, call);
            break;
        case MsgType::publish:
            if (const auto m = mqttsn::decode_publish(body)) return on_publish(body, *m, call.out);
            break;
        case MsgType::puback:
            if (const auto m = mqttsn::decode_puback(body)) return on_puback(*m, call);
            break;
        case MsgType::pubrec:
            if (const auto m = mqttsn::decode_pubrec(body)) return on_pubrec(*m, call);
            break;
        case MsgType::pubrel:
            if (const auto m = mqttsn::decode_pubrel(body)) return on_pubrel(*m, call.out);
            break;
        case MsgType::pubcomp:
            if (const auto m = mqttsn::decode_pubcomp(body)) return on_pubcomp(*m, call);
            break;
        case MsgType::suback:
            if (const auto m = mqttsn::decode_suback(body)) return on_suback(*m, call);
            break;
        case MsgType::unsuback:
            if (const auto m = mqttsn::decode_unsuback(body)) return on_unsuback(*m, call);
            break;
        case MsgType::pingreq:
            return on_pingreq(call.out);
        case MsgType::pingresp:
            if (body.empty()) return on_pingresp(call);
            break;
        case MsgType::disconnect:
            if (mqttsn::decode_disconnect(body)) return on_disconnect(call);
            break;
        case MsgType::willtopicresp:
            if (const auto m = mqttsn::decode_willtopicresp(body)) {
                return on_will_response(Operation::Kind::will_topic, m->return_code, call);
            }
            break;
        case MsgType::willmsgresp:
            if (const auto m = mqttsn::decode_willmsgresp(body)) {
                return on_will_response(Operation::Kind::will_message, m->return_code, call);
            }
            break;
        default:  // what only brokers receive, discovery, reserved types
            break;
    }
    drop();
}

void ClientCore::on_tick(Instant now, Output& out) {
    out.clear();
    const Call call{now, out};
    if (exchange_.is_due(now)) {
        if (exchange_.repeat(now, timing_.t_retry)) {
            repeat_request(out);
        } else {
            give_up(call);
        }
    }
    if (collect_due_ <= now) begin_collecting(call);
    tick_keep_alive(call);
    carry_on(call);
}

Instant ClientCore::next_wakeup() const {
    if (unfinished_) return Instant::min();
    Instant next = std::min({exchange_.deadline(), ping_.deadline(), ping_due_, collect_due_});
    const bool waits_for_pause =
        state_ == State::connected && !exchange_.is_running() && !operations_.empty();
    if (waits_for_pause) next = std::min(next, paused_until_);
    return next;
}

void ClientCore::start_exchange(Instant now) {
    exchange_.start(now, timing_.t_retry, timing_.n_retry);
}

void ClientCore::repeat_request(Output& out) {
    switch (state_) {
        case State::connecting:
            return send_connect_step(out);
        case State::connected:
            return send_front(true, out);
        case State::awake:
            return send(mqttsn::Pingreq{options_.client_id}, out);
        case State::disconnecting:
        case State::falling_asleep:
            return send_disconnect(out);
        case State::disconnected:
        case State::asleep:
            return;
    }
}

/// Nretry repetitions were not answered (6.13).
void ClientCore::give_up(const Call& call) {
    if (state_ == State::awake) return fall_asleep(call);
    if (state_ == State::disconnecting) {
        return become_disconnected(Disconnected{.by_broker = false}, call.out);
    }
    become_disconnected(Lost{}, call.out);
}

}  // namespace romano::client
