#include "romano/dtls/client_link.h"

#include "romano/mqttsn/frame.h"

namespace romano::dtls {

void ClientLink::send(Bytes message) {
    const auto frame = mqttsn::decode_frame(message);
    const bool is_connect = frame && frame->type == mqttsn::MsgType::connect;
    if (is_connect) waiting_.clear();
    if (is_handshake_due(is_connect)) {
        ++handshakes_;
        unanswered_ = 0;
        was_heard_ = false;
        end_.connect();
    }
    if (end_.is_connected()) {
        (void)end_.seal(message);
        return;
    }
    if (waiting_.size() == most_waiting) waiting_.erase(waiting_.begin());
    waiting_.emplace_back(message.begin(), message.end());
}

bool ClientLink::is_handshake_due(bool is_connect) {
    if (end_.is_closed()) return true;
    if (!is_connect) return false;
    return was_heard_ || ++unanswered_ == unanswered_connects;
}

Bytes ClientLink::open(Bytes datagram) {
    const Bytes message = end_.open(datagram);
    if (!message.empty()) was_heard_ = true;
    if (end_.is_connected() && !waiting_.empty()) {
        for (const auto& waited : std::exchange(waiting_, {})) (void)end_.seal(waited);
    }
    return message;
}

}  // namespace romano::dtls
