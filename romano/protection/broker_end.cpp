#include "romano/protection/broker_end.h"

#include <utility>

#include "romano/mqttsn/frame.h"

namespace romano::protection {

BrokerEnd::BrokerEnd(const DirectionKeys& keys, std::string_view client_id, const SenderId& broker,
                     Reserve& reserve, std::optional<Heard> heard)
    : sealer_(keys.to_robot, broker, reserve),
      to_broker_(keys.to_broker),
      robot_(sender_id(client_id)),
      stored_(heard) {
    if (!heard) return;
    run_ = heard->run;
    window_ = ReplayWindow{heard->floor};
    is_first_ = true;
}

std::size_t BrokerEnd::seal(Bytes message, MutableBytes out) {
    if (run_) return sealer_.seal(*run_, message, out, refusals_);
    refusals_.count(Refusal::robot_unheard);
    return 0;
}

Bytes BrokerEnd::open(MutableBytes datagram) {
    const auto packet = parse(datagram);
    if (!packet) return refuse(packet.error());
    const Fields fields = packet->fields();
    if (fields.number >= max_number) return refuse(Refusal::malformed);
    if (fields.sender != robot_) return refuse(Refusal::unknown_sender);
    if (window_.has_seen(fields.number)) return refuse(Refusal::replayed);
    if (!protection::open(*packet, to_broker_)) return refuse(Refusal::bad_tag);
    // A packet that was overtaken may still tell of the run before.
    if (window_.is_newest(fields.number)) run_ = fields.run;
    if (std::exchange(is_first_, false)) {
        window_ = ReplayWindow{fields.number + 1};
    } else {
        window_.note(fields.number);
    }
    const auto frame = mqttsn::decode_frame(packet->message());
    if (frame && frame->type == mqttsn::MsgType::encapsulated) return refuse(Refusal::forwarded);
    return packet->message();
}

Bytes BrokerEnd::refuse(Refusal why) {
    refusals_.count(why);
    return {};
}

std::optional<Heard> BrokerEnd::to_store() const {
    if (!run_ || window_.end() == 0) return std::nullopt;
    const Heard wanted{*run_, Reserve::block_of(window_.end() - 1) + numbers_a_block};
    if (stored_ && stored_->run == wanted.run && stored_->floor >= wanted.floor) {
        return std::nullopt;
    }
    return wanted;
}

std::optional<Heard> BrokerEnd::heard() const {
    if (!run_) return std::nullopt;
    return Heard{*run_, window_.end()};
}

}  // namespace romano::protection
