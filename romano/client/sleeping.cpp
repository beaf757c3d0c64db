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
    start_exchange(now);
    send_disconnect(out);
}

void ClientCore::wake(Instant now, Output& out) {
    out.clear();
    if (state_ == State::asleep) begin_collecting({now, out});
}

void ClientCore::begin_collecting(const Call& call) {
    state_ = State::awake;
    collect_due_ = never;
    start_exchange(call.now);
    repeat_request(call.out);
}

/// Also after Nretry unanswered PINGREQs: the client sleeps on and tries again in its next period
/// (6.14d).
void ClientCore::fall_asleep(const Call& call) {
    state_ = State::asleep;
    stop_timers();
    collect_due_ = call.now + before_end_of(KeepAlive{sleep_duration_s_});
    call.out.tell(Asleep{});
}

}  // namespace romano::client
