// Tretry and Nretry of one exchange: MQTT-SN 1.2 section 6.13.
#pragma once

#include <cstdint>

#include "romano/base/time.h"

namespace romano::client {

class RetryTimer {
public:
    /// A request has just been sent for the first time.
    void start(Instant now, Duration t_retry, int n_retry) {
        deadline_ = now + t_retry;
        left_ = static_cast<std::int16_t>(n_retry);
    }
    void stop() { deadline_ = never; }

    /// The answer is overdue: true when the request may be sent once more.
    [[nodiscard]] bool repeat(Instant now, Duration t_retry) {
        if (left_ == 0) return false;
        --left_;
        deadline_ = now + t_retry;
        return true;
    }

    /// A sign of life that is no answer: the wait begins anew, the repetitions do not.
    void put_off(Instant now, Duration t_retry) { deadline_ = now + t_retry; }

    [[nodiscard]] bool is_running() const { return deadline_ != never; }
    [[nodiscard]] bool is_due(Instant now) const { return deadline_ <= now; }
    [[nodiscard]] Instant deadline() const { return deadline_; }

private:
    Instant deadline_ = never;
    std::int16_t left_ = 0;
};

}  // namespace romano::client
