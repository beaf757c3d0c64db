#include "overlay/sim/event_queue.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::sim {

bool EventQueue::later(const Entry& a, const Entry& b) {
    return a.when != b.when ? a.when > b.when : a.sequence > b.sequence;
}

void EventQueue::at(Instant when, Event event) {
    heap_.push_back({std::max(when, now_), next_sequence_++, std::move(event)});
    std::ranges::push_heap(heap_, later);
}

void EventQueue::run_until(Instant end) {
    while (!heap_.empty() && heap_.front().when <= end) {
        std::ranges::pop_heap(heap_, later);
        const Entry entry = std::move(heap_.back());
        heap_.pop_back();
        at_this_time_ = entry.when == now_ ? at_this_time_ + 1 : 0;
        assert(at_this_time_ < livelock &&
               "somebody asks for the time that it already is, for ever");
        now_ = entry.when;
        ++run_;
        entry.event();
    }
    now_ = end;
}

}  // namespace romano::sim
