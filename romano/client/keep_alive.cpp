// MQTT-SN 1.2 section 6.11: keep-alive, both ways.
//
// A PINGREQ is due when nothing was answered for three quarters of the keep-alive period; the last
// quarter is left for its repetitions. An answered request of another kind tells both sides as much
// as a ping; datagrams that nobody answers tell the client nothing.
#include "romano/client/client.h"

namespace romano::client {

/// The broker has answered a request, so it has heard of us.
void ClientCore::on_sign_of_life(Instant now) {
    if (ping_.is_running()) return;  // that PINGREQ wants its own answer
    ping_due_ = options_.keep_alive.count() == 0 ? never : now + before_end_of(options_.keep_alive);
}

/// Three quarters of a period.
Duration ClientCore::before_end_of(KeepAlive period) {
    return Duration{period} * 3 / 4;
}

void ClientCore::tick_keep_alive(const Call& call) {
    if (ping_.is_due(call.now)) {
        if (!ping_.repeat(call.now, timing_.t_retry)) return become_disconnected(Lost{}, call.out);
    } else if (ping_due_ <= call.now) {
        ping_.start(call.now, timing_.t_retry, timing_.n_retry);
        ping_due_ = never;
    } else {
        return;
    }
    call.out.send(mqttsn::MsgType::pingreq, {});
}

/// Pings also when no ping would be due for long, or ever: the former broker would go on talking to
/// us. What is open is asked again at once, for the former broker's answer may not reach us, and as
/// often as if it were new.
void ClientCore::on_broker_changed(Instant now) {
    if (exchange_.is_running()) exchange_.start(now, Duration{0}, timing_.n_retry);
    if (state_ == State::connected) ping_.stop();
    probe(now);
}

void ClientCore::probe(Instant now) {
    if (state_ == State::connected && !ping_.is_running()) ping_due_ = now;
}

void ClientCore::on_pingresp(const Call& call) {
    if (state_ == State::awake) return fall_asleep(call);
    if (state_ != State::connected) return drop();
    ping_.stop();
    on_sign_of_life(call.now);
}

/// The broker asks whether we live.
void ClientCore::on_pingreq(Output& out) {
    if (!is_receiving()) return drop();
    out.send(mqttsn::MsgType::pingresp, {});
}

}  // namespace romano::client
