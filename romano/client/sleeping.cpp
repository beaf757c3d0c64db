// MQTT-SN 1.2 section 6.14: the client sleeps and collects its messages now and then.
#include <algorithm>

#include "romano/client/client.h"

namespace romano::client {

void ClientCore::sleep(Instant now, std::chrono::seconds duration, Output& out) {
    out.clear();
    if (state_ == State::disconnected || state_ == State::connecting) return;
    sleep_duration_s_ =
        static_cast<std::uint16_t>(std::clamp<std::int64_t>(duration.count(), 1, 0xFFFF));
    state_ = State::falling_asleep;
    stop_timers();
    send_disconnect(out);
    exchange_.start(now, timing_.t_retry, timing_.n_retry);
}

void ClientCore::wake(Instant now, Output& out) {
    out.clear();
    if (state_ == State::asleep) begin_collecting(now, out);
}

void ClientCore::begin_collecting(Instant now, Output& out) {
    state_ = State::awake;
    collect_due_ = never;
    send_collect(out);
    exchange_.start(now, timing_.t_retry, timing_.n_retry);
}

void ClientCore::send_collect(Output& out) {
    send(mqttsn::Pingreq{options_.client_id}, out);
}

/// Also after Nretry unanswered PINGREQs: the client sleeps on and tries again in its next period
/// (6.14d).
void ClientCore::fall_asleep(Instant now, Output& out) {
    state_ = State::asleep;
    stop_timers();
    collect_due_ = now + before_end_of(sleep_duration_s_);
    out.tell(Asleep{});
}

}  // namespace romano::client
