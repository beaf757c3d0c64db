// Messages that the broker sends once for its cell (mqttsn/cell.h).
#include "romano/mqttsn/cell.h"

#include "romano/client/client.h"

namespace romano::client {

using mqttsn::MsgType;
using mqttsn::Qos;

/// What is for others is no mistake: it is passed over, and not counted.
void ClientCore::on_cell_publish(const mqttsn::Body& message, const Call& call) {
    const auto cell = mqttsn::read_cell_publish(message);
    if (!cell) return drop();
    if (!listens_ || state_ != State::connected) return;
    const mqttsn::TopicId id = topics_.id_of(cell->name);
    const std::uint16_t self = mqttsn::listener_number(options_.client_id);
    if (id == mqttsn::no_topic_id || !cell->is_for(self)) return;

    const bool goes_on = cell->behind != mqttsn::no_msg_id;
    if (goes_on && cell->behind != last_taken_) return;  // what was before it comes by unicast yet

    const Qos qos = mqttsn::qos_in(message.flags);
    if (qos == Qos::at_least_once && !goes_on) answer_cell(call.out);
    call.out.tell(
        Received{{mqttsn::TopicIdType::normal, cell->name, id}, cell->payload, qos, false, false});
    if (qos == Qos::at_most_once) return;
    last_taken_ = message.msg_id;
    if (cell_answer_at_ == never) {
        cell_answer_at_ = call.now + mqttsn::cell_answer_delay(cell->answer_steps, self);
    }
    cell_answer_ = {.topic_id = id, .msg_id = message.msg_id};
}

/// Answers come in the order of their messages: a PUBACK that is owed goes before what follows. Of
/// messages that go on to the cell the last one is answered, at the time of the first.
void ClientCore::answer_cell(Output& out) {
    if (cell_answer_at_ == never) return;
    cell_answer_at_ = never;
    out.send(MsgType::puback, {.topic_id = cell_answer_.topic_id, .msg_id = cell_answer_.msg_id});
}

}  // namespace romano::client
