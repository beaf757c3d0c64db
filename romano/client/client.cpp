// Input to its exchange, and the operations in their turn. The exchanges themselves: see client.h.
#include "romano/client/client.h"

#include <algorithm>

#include "romano/mqttsn/frame.h"

namespace romano::client {

using mqttsn::MsgType;

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
    auto message = mqttsn::read_body(frame->type, frame->body);
    if (!message) return drop();
    const bool is_cells = frame->type == MsgType::publish &&
                          mqttsn::topic_type_in(message->flags) == mqttsn::TopicIdType::reserved;
    if (hears_cells && !is_cells) answer_cell(out);
    // Whatever comes while awake shows that the broker is not done yet (6.14d).
    if (state_ == State::awake) exchange_.put_off(now, timing_.t_retry);
    dispatch(frame->type, *message, {now, out});
    carry_on({now, out});
}

void ClientCore::dispatch(MsgType type, mqttsn::Body& message, const Call& call) {
    switch (type) {
        case MsgType::connack:
            return on_connack(message.code, call);
        case MsgType::willtopicreq:
        case MsgType::willmsgreq:
            return on_will_prompt(type, call);
        case MsgType::register_:
            return on_register(message, call.out);
        case MsgType::publish:
            return on_publish(message, call);
        case MsgType::pubrel:
            return on_pubrel(message, call.out);
        case MsgType::pingreq:
            return on_pingreq(call.out);
        case MsgType::pingresp:
            return on_pingresp(call);
        case MsgType::disconnect:
            return on_disconnect(call);
        case MsgType::regack:
        case MsgType::puback:
        case MsgType::pubrec:
        case MsgType::pubcomp:
        case MsgType::suback:
        case MsgType::unsuback:
        case MsgType::willtopicresp:
        case MsgType::willmsgresp:
            return on_answer(type, message, call);
        default:  // what only brokers receive, discovery, reserved types
            return drop();
    }
}

void ClientCore::on_tick(Instant now, Output& out) {
    out.clear();
    const Call call{now, out};
    if (hears_cells && cell_answer_at_ <= now) answer_cell(out);
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
    Instant next = exchange_.deadline();
    next = std::min(next, ping_.deadline());
    next = std::min(next, ping_due_);
    next = std::min(next, collect_due_);
    if constexpr (hears_cells) next = std::min(next, cell_answer_at_);
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
            return out.send(MsgType::pingreq, {.rest = as_octets(options_.client_id)});
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
