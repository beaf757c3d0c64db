#include "firmware/posix/protected_board.h"

#include "romano/mqttsn/frame.h"

namespace romano::firmware {
namespace {

bool is_discovery(Bytes datagram) {
    const auto frame = mqttsn::decode_frame(datagram);
    return frame &&
           (frame->type == mqttsn::MsgType::advertise || frame->type == mqttsn::MsgType::searchgw ||
            frame->type == mqttsn::MsgType::gwinfo);
}

}  // namespace

ProtectedBoard::ProtectedBoard(const romano_board& board, keys::ClientPackets& packets)
    : inner_(board), packets_(packets), own_(board) {
    own_.self = this;
    own_.now_ms = [](void* self) {
        const romano_board& inner = static_cast<ProtectedBoard*>(self)->inner_;
        return inner.now_ms(inner.self);
    };
    own_.send = [](void* self, const romano_address* to, const std::uint8_t* octets,
                   std::uint32_t size) {
        static_cast<ProtectedBoard*>(self)->send(to, {octets, size});
    };
    own_.receive = [](void* self, romano_address* from, std::uint32_t* size) {
        return static_cast<ProtectedBoard*>(self)->receive(from, size);
    };
    if (board.link_dbm == nullptr) return;
    own_.link_dbm = [](void* self, const romano_address* peer) {
        const romano_board& inner = static_cast<ProtectedBoard*>(self)->inner_;
        return inner.link_dbm(inner.self, peer);
    };
}

void ProtectedBoard::send(const romano_address* to, Bytes message) {
    const Bytes datagram = is_discovery(message) ? message : packets_.seal(message);
    if (datagram.empty()) return;  // no number is left
    inner_.send(inner_.self, to, datagram.data(), static_cast<std::uint32_t>(datagram.size()));
}

const std::uint8_t* ProtectedBoard::receive(romano_address* from, std::uint32_t* size) {
    while (const std::uint8_t* octets = inner_.receive(inner_.self, from, size)) {
        if (is_discovery({octets, *size})) return octets;
        packet_.assign(octets, octets + *size);
        const Bytes message = packets_.open(packet_);
        if (message.empty()) continue;
        *size = static_cast<std::uint32_t>(message.size());
        return message.data();
    }
    return nullptr;
}

}  // namespace romano::firmware
