#include "romano/client/search_answer.h"

#include "romano/client/gateway_address.h"
#include "romano/mqttsn/codec.h"

namespace romano::client {

void SearchAnswer::on_datagram(Instant now, Bytes datagram) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return;
    if (frame->type == mqttsn::MsgType::gwinfo) {
        due_ = never;  // somebody was faster
    } else if (frame->type == mqttsn::MsgType::searchgw && due_ == never &&
               !discovery_.gateways().empty()) {
        due_ = now + random_.between(Duration::zero(), t_gwinfo_);
    }
}

std::size_t SearchAnswer::on_tick(Instant now, MutableBytes out) {
    if (now < due_) return 0;
    due_ = never;
    if (discovery_.gateways().empty()) return 0;  // forgotten meanwhile
    const Gateway& gateway = discovery_.gateways()[0];
    const auto address = write_gateway_address(gateway.address);
    return mqttsn::encode(mqttsn::Gwinfo{gateway.id, address}, out);
}

}  // namespace romano::client
