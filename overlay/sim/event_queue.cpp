#include "overlay/sim/event_queue.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace romano::sim {

bool EventQueue::later(const Entry& a, const Entry& b) {
    return a.when != b.when ? a.when > b.when : a.sequence > b.sequence;
}

void EventQueue::at(Instant when, Event event) {
    std::size_t slot = events_.size();
    if (free_slots_.empty()) {
        events_.push_back(std::move(event));
    } else {
        slot = free_slots_.back();
        free_slots_.pop_back();
        events_[slot] = std::move(event);
    }
    heap_.push_back({std::max(when, now_), next_sequence_++, slot});
    std::ranges::push_heap(heap_, later);
}

void EventQueue::run_until(Instant end) {
    while (!heap_.empty() && heap_.front().when <= end) {
        std::ranges::pop_heap(heap_, later);
        const Entry entry = heap_.back();
        heap_.pop_back();
        at_this_time_ = entry.when == now_ ? at_this_time_ + 1 : 0;
        assert(at_this_time_ < livelock && "somebody asks for the present time for ever");
        now_ = entry.when;
        const Event event = std::exchange(events_[entry.slot], nullptr);
        free_slots_.push_back(entry.slot);
        event();
    }
    now_ = end;
}

}  // namespace romano::sim
