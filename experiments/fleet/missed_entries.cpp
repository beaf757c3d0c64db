#include "experiments/fleet/missed_entries.h"

#include <utility>

namespace romano::experiments {

void MissedEntries::on_subscribed(Instant now) {
    is_asked_ = false;
    is_answering_ = true;
    last_answer_ = now;
    told_.clear();
}

void MissedEntries::on_entry(Instant now, const message::RomanoId& robot, bool is_answer) {
    if (is_answering_) told_.insert(robot);
    if (is_answer) {
        last_answer_ = now;
        return;
    }
    if (news_++ == 0) first_news_ = now;
    last_news_ = now;
}

bool MissedEntries::asks(Instant now) {
    if (is_asked_ || is_answering_) return false;
    if (news_ > 0 && news_ < burst && now - last_news_ >= burst_is_over_after) news_ = 0;
    const bool is_over =
        now - last_news_ >= burst_is_over_after || now - first_news_ >= longest_burst;
    if (news_ < burst || !is_over) return false;
    news_ = 0;
    return is_asked_ = true;
}

bool MissedEntries::is_answered(Instant now) {
    return is_answering_ && now - last_answer_ >= answer_is_over_after &&
           std::exchange(is_answering_, false);
}

}  // namespace romano::experiments
