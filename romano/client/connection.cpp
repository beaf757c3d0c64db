// MQTT-SN 1.2 sections 6.2 (connect, with the will's prompts), 6.3 (clean session) and 6.12.
#include "romano/client/client.h"

namespace romano::client {

using mqttsn::MsgType;

void ClientCore::connect(Instant now, const ConnectOptions& options, Output& out) {
    out.clear();
    options_ = options;
    state_ = State::connecting;
    if constexpr (hears_cells) {
        listens_ = false;
        last_taken_ = mqttsn::no_msg_id;
    }
    stop_timers();
    begin_connect_step(MsgType::connect, {now, out});
}

void ClientCore::begin_connect_step(MsgType step, const Call& call) {
    connect_step_ = step;
    start_exchange(call.now);
    send_connect_step(call.out);
}

void ClientCore::send_connect_step(Output& out) {
    const std::optional<Will>& will = options_.will;
    mqttsn::Body body;
    if (connect_step_ == MsgType::connect) {
        body.flags =
            mqttsn::to_wire({.will = will.has_value(), .clean_session = options_.clean_session});
        body.msg_id = mqttsn::MsgId{options_.keep_alive.count()};
        body.rest = as_octets(options_.client_id);
    } else if (connect_step_ == MsgType::willtopic) {
        body.flags = mqttsn::to_wire({.qos = will->qos, .retain = will->retain});
        body.rest = as_octets(will->topic);
    } else {
        body.rest = will->message;
    }
    out.send(connect_step_, body);
}

/// A prompt may come twice, as every message; the answer is given again (6.2d). Its number is that
/// of the prompt plus one (5.2.2).
void ClientCore::on_will_prompt(MsgType prompt, const Call& call) {
    if (state_ != State::connecting || !options_.will) return drop();
    begin_connect_step(MsgType(static_cast<std::uint8_t>(prompt) + 1), call);
}

void ClientCore::on_connack(mqttsn::ReturnCode code, const Call& call) {
    if (state_ != State::connecting) return drop();
    if (code != mqttsn::ReturnCode::accepted) return become_disconnected(Refused{code}, call.out);
    exchange_.stop();
    state_ = State::connected;
    on_sign_of_life(call.now);
    call.out.tell(Connected{});
    if (options_.clean_session) {
        topics_.clear();
        unreleased_count_ = 0;
    }
    resume_front(call);
}

void ClientCore::disconnect(Instant now, Output& out) {
    out.clear();
    if (state_ == State::disconnected) return;
    state_ = State::disconnecting;
    sleep_duration_s_ = 0;
    stop_timers();
    start_exchange(now);
    send_disconnect(out);
}

void ClientCore::send_disconnect(Output& out) {
    out.send(MsgType::disconnect, {.msg_id = mqttsn::MsgId{sleep_duration_s_}});
}

void ClientCore::on_disconnect(const Call& call) {
    switch (state_) {
        case State::disconnected:
        case State::connecting:  // meant for a datagram before CONNECT (G8)
            return drop();
        case State::falling_asleep:
            return fall_asleep(call);
        case State::disconnecting:
            return become_disconnected(Disconnected{.by_broker = false}, call.out);
        case State::connected:
        case State::asleep:
        case State::awake:
            return become_disconnected(Disconnected{.by_broker = true}, call.out);
    }
}

void ClientCore::become_disconnected(const Event& why, Output& out) {
    state_ = State::disconnected;
    stop_timers();
    out.tell(why);
}

void ClientCore::stop_timers() {
    exchange_.stop();
    ping_.stop();
    ping_due_ = never;
    collect_due_ = never;
    if constexpr (hears_cells) cell_answer_at_ = never;
}

}  // namespace romano::client
