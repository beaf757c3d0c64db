// Robots' entries that one who listens has not heard: for one client a broker keeps a thousand
// messages that wait, and when thousands of robots come, leave or change their home at once, what
// is more is dropped. After such a burst all entries are asked for once more, and a robot that the
// answer does not name has left.
//
// A core without I/O: it is told what comes, and says when to subscribe again.
#pragma once

#include <cstddef>
#include <set>

#include "romano/base/time.h"
#include "romano/message/romano_id.h"

namespace romano::experiments {

class MissedEntries {
public:
    static constexpr std::size_t burst = 100;  // a tenth of what waits at a broker at most
    static constexpr Duration burst_is_over_after = std::chrono::seconds{1};
    static constexpr Duration longest_burst = std::chrono::seconds{30};
    static constexpr Duration answer_is_over_after = std::chrono::seconds{5};

    /// The broker has taken a subscription to all entries, and tells what it has.
    void on_subscribed(Instant now);
    /// An entry, or word that there is none any more. `is_answer`: it was there before.
    void on_entry(Instant now, const message::RomanoId& robot, bool is_answer);
    void on_lost() { *this = {}; }

    /// Subscribe once more. Said once for each burst.
    [[nodiscard]] bool asks(Instant now);
    /// The answer is over. Said once; was_told() holds until the next subscription.
    [[nodiscard]] bool is_answered(Instant now);
    [[nodiscard]] bool was_told(const message::RomanoId& robot) const {
        return told_.contains(robot);
    }

private:
    std::size_t news_ = 0;
    Instant first_news_{};
    Instant last_news_{};
    bool is_asked_ = false;  // and the broker has not taken it yet
    bool is_answering_ = false;
    Instant last_answer_{};
    std::set<message::RomanoId> told_;
};

}  // namespace romano::experiments
