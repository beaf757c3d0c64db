#include "romano/client/events.h"

#include <cassert>

#include "romano/mqttsn/frame.h"

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

std::uint8_t* Output::begin(mqttsn::MsgType type, std::size_t body_size) {
    const MutableBytes room = octets_.subspan(used_);
    std::uint8_t* body = mqttsn::begin_frame(type, body_size, room);
    assert(body != nullptr);  // an Output for smaller limits than the client's
    assert(datagram_count_ < most);
    if (body == nullptr) return nullptr;
    const std::size_t size = mqttsn::framed_size(body_size);
    datagrams_[datagram_count_++] = room.first(size);
    used_ += size;
    return body;
}

void Output::tell(const Event& event) {
    assert(event_count_ < most);
    events_[event_count_++] = event;
}

}  // namespace romano::client
