#include "broker/core/outbox.h"

#include <cassert>
#include <variant>

#include "romano/base/bytes.h"

namespace romano::broker {

Outbox::Octets Outbox::last_sent(const Turn& turn) {
    const Send& last = std::get<Send>(turn.out.list().back());
    return {last.offset, last.size};
}

void Outbox::repeat(const Session& session, Octets octets, Turn& turn) {
    assert(session.header.address.wireless_node_id.empty());
    turn.out.push(Send{session.header.via, session.header.address, session.output_floor,
                       octets.offset, octets.size});
    count(mqttsn::MsgType::publish);
}

void Outbox::wrap(const ClientAddress& to, MutableBytes room) {
    const Bytes node_id = as_octets(to.wireless_node_id);
    const std::size_t size = mqttsn::encode(
        mqttsn::Encapsulated{.radius = 0, .wireless_node_id = node_id, .message = {}},
        room.first(3 + node_id.size()));
    assert(size == 3 + node_id.size());
    (void)size;
}

}  // namespace romano::broker
