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

void Output::send(mqttsn::MsgType type, const mqttsn::Body& body) {
    assert(datagram_count_ < most);
    const MutableBytes room = octets_.subspan(used_);
    const std::size_t size = mqttsn::write_message(type, body, room);
    assert(size != 0);  // an Output for smaller limits than the client's
    if (size == 0) return;
    datagrams_[datagram_count_++] = room.first(size);
    used_ += size;
}

void Output::tell(const Event& event) {
    assert(event_count_ < most);
    events_[event_count_++] = event;
}

}  // namespace romano::client
