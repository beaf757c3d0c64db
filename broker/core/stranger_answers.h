// How many answers of a kind strangers hear in a second, all addresses together, spread evenly:
// behind a tenth of a second's worth each waits for its turn, and those between are dropped. Who
// floods from ever new addresses, true or forged, then costs a broker no more than reading and
// looking up, and the clients that it serves do not wait behind answers.
//
// Each kind has its own, so that a flood of one leaves the others: DISCONNECT; GWINFO; to a CONNECT
// "no", or the question for its will once more; and "no" to a CONNECT that lacks its client's key
// (broker/protection). A CONNECT that goes on is not counted: a swarm may come at once.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "romano/base/time.h"

namespace romano::broker {

class StrangerAnswers {
public:
    explicit StrangerAnswers(std::size_t per_second)
        : each_(std::chrono::duration_cast<Duration>(std::chrono::seconds{1}) /
                static_cast<Duration::rep>(per_second)),
          ahead_(std::max<Duration>(each_, std::chrono::milliseconds{100})) {}

    /// True when one more may be answered.
    bool allows(Instant now) {
        const Instant used = std::max(used_until_, now - ahead_) + each_;
        if (used > now) return false;
        used_until_ = used;
        return true;
    }

private:
    Duration each_;
    Duration ahead_;
    Instant used_until_ = Instant::min();
};

}  // namespace romano::broker
