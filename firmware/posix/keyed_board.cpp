#include "firmware/posix/keyed_board.h"

#include <utility>

#include "firmware/robot/address.h"
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

KeyedBoard::KeyedBoard(const romano_board& behind, std::shared_ptr<keys::ClientPackets> key)
    : behind_(behind), key_(std::move(key)), own_(behind) {
    own_.self = this;
    own_.now_ms = [](void* self) {
        const romano_board& board = static_cast<KeyedBoard*>(self)->behind_;
        return board.now_ms(board.self);
    };
    own_.send = [](void* self, const romano_address* to, const std::uint8_t* octets,
                   std::uint32_t size) {
        static_cast<KeyedBoard*>(self)->send(*to, {octets, size});
    };
    own_.receive = [](void* self, romano_address* from, std::uint32_t* size) {
        return static_cast<KeyedBoard*>(self)->receive(from, size);
    };
    if (behind.link_dbm == nullptr) return;
    own_.link_dbm = [](void* self, const romano_address* peer) {
        const romano_board& board = static_cast<KeyedBoard*>(self)->behind_;
        return board.link_dbm(board.self, peer);
    };
}

void KeyedBoard::put(const romano_address& to, Bytes datagram) const {
    behind_.send(behind_.self, &to, datagram.data(), static_cast<std::uint32_t>(datagram.size()));
}

void KeyedBoard::send(const romano_address& to, Bytes message) {
    if (is_discovery(message)) return put(to, message);
    const Endpoint wanted = endpoint_of(to);
    if (!speech_ || wanted != broker_) {
        broker_ = wanted;
        speech_ = keys::speak(key_, [this, to](Bytes datagram) { put(to, datagram); });
    }
    speech_->send(message);
}

const std::uint8_t* KeyedBoard::receive(romano_address* from, std::uint32_t* size) {
    if (speech_) speech_->on_time();
    while (const std::uint8_t* octets = behind_.receive(behind_.self, from, size)) {
        const Bytes datagram{octets, *size};
        if (is_discovery(datagram)) return octets;
        if (!speech_ || endpoint_of(*from) != broker_) continue;
        const Bytes message = speech_->open(datagram);
        if (message.empty()) continue;
        *size = static_cast<std::uint32_t>(message.size());
        return message.data();
    }
    return nullptr;
}

}  // namespace romano::firmware
