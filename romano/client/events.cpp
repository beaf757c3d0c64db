#include "romano/client/events.h"

#include <cassert>

namespace romano::client {

void Output::clear() {
    used_ = 0;
    datagram_count_ = 0;
    event_count_ = 0;
}

bool Output::has_room() const {
    return datagram_count_ + 2 <= most && event_count_ + 2 <= most &&
           used_ <= small_datagrams_octets;
}

void Output::send(std::size_t size) {
    assert(size != 0 && size <= octets_.size() - used_);  // an Output for smaller limits than ours
    assert(datagram_count_ < most);
    datagrams_[datagram_count_++] = Bytes{octets_}.subspan(used_, size);
    used_ += size;
}

void Output::tell(const Event& event) {
    assert(event_count_ < most);
    events_[event_count_++] = event;
}

}  // namespace romano::client
