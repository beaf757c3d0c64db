// MQTT-SN 1.2 sections 6.2 (connect, with the will's prompts), 6.3 (clean session) and 6.12.
#include "romano/client/client.h"

namespace romano::client {

void ClientCore::connect(Instant now, const ConnectOptions& options, Output& out) {
    out.clear();
    options_ = options;
    state_ = State::connecting;
    stop_timers();
    begin_connect_step(ConnectStep::connect, {now, out});
}

void ClientCore::begin_connect_step(ConnectStep step, const Call& call) {
    connect_step_ = step;
    start_exchange(call.now);
    send_connect_step(call.out);
}

void ClientCore::send_connect_step(Output& out) {
    switch (connect_step_) {
        case ConnectStep::connect:
            return send(mqttsn::Connect{.will = options_.will.has_value(),
                                        .clean_session = options_.clean_session,
                                        .protocol_id = mqttsn::protocol_id,
                                        .duration_s = options_.keep_alive.count(),
                                        .client_id = options_.client_id},
                        out);
        case ConnectStep::will_topic:
            return send(
                mqttsn::Willtopic{options_.will->qos, options_.will->retain, options_.will->topic},
                out);
        case ConnectStep::will_message:
            return send(mqttsn::Willmsg{options_.will->message}, out);
    }
}

/// A prompt may come twice, as every message; the answer is given again (6.2d).
void ClientCore::on_will_prompt(ConnectStep step, const Call& call) {
    if (state_ != State::connecting || !options_.will) return drop();
    begin_connect_step(step, call);
}

void ClientCore::on_connack(const mqttsn::Connack& message, const Call& call) {
    if (state_ != State::connecting) return drop();
    if (message.return_code != mqttsn::ReturnCode::accepted) {
        return become_disconnected(Refused{message.return_code}, call.out);
    }
    exchange_.stop();
    state_ = State::connected;
    on_answer(call.now);
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
    stop_timers();
    start_exchange(now);
    send_disconnect(out);
}

/// With a duration when it is the beginning of a sleep.
void ClientCore::send_disconnect(Output& out) {
    const bool sleeps = state_ == State::falling_asleep;
    send(mqttsn::Disconnect{sleeps, sleep_duration_s_}, out);
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
}

}  // namespace romano::client
