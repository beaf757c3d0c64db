#include "overlay/radio/watched_scheduler.h"

#include <ns3/nstime.h>

#include <limits>

namespace romano::lowpan {

WatchedScheduler* WatchedScheduler::current_ = nullptr;

ns3::TypeId WatchedScheduler::GetTypeId() {
    static const ns3::TypeId id = ns3::TypeId("romano::lowpan::WatchedScheduler")
                                      .SetParent<ns3::MapScheduler>()
                                      .AddConstructor<WatchedScheduler>();
    return id;
}

std::int64_t WatchedScheduler::next_ns() {
    if (current_ == nullptr || current_->IsEmpty()) return std::numeric_limits<std::int64_t>::max();
    return ns3::TimeStep(current_->PeekNext().key.m_ts).GetNanoSeconds();
}

}  // namespace romano::lowpan
