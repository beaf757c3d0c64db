#include "overlay/member/cut_off.h"

#include "romano/mqttsn/frame.h"

namespace romano::overlay {
namespace {

constexpr std::uint8_t dup = 0x80;  // MQTT-SN 1.2 section 5.3.4

bool is_repetition(Bytes datagram) {
    auto frame = mqttsn::decode_frame(datagram);
    if (frame && !frame->wrapped.empty()) frame = mqttsn::decode_frame(frame->wrapped);
    if (!frame) return false;
    if (frame->type == mqttsn::MsgType::pubrel) return true;
    return frame->type == mqttsn::MsgType::publish && !frame->body.empty() &&
           (frame->body[0] & dup) != 0;
}

}  // namespace

bool CutOff::on_view(const cluster::View& view, const HasEnded& has_ended) {
    if (view.number == seen_ || view.members.empty()) return false;
    seen_ = view.number;
    const bool was_possible = is_possible();
    missing_.merge(members_);
    members_ = {view.members.begin(), view.members.end()};
    present_ = members_.size();
    std::erase_if(missing_, [&](const broker::LogId& member) {
        return members_.contains(member) || has_ended(member);
    });
    if (!is_possible()) missing_.clear();
    if (!was_possible || !is_possible()) heard_.clear();
    return was_possible && !is_possible();
}

void CutOff::on_heard(const Endpoint& client) {
    if (is_possible() && heard_.size() < heard_most) heard_.insert(client);
}

bool CutOff::withholds(const Endpoint& client, Bytes datagram) const {
    return is_possible() && !heard_.contains(client) && is_repetition(datagram);
}

}  // namespace romano::overlay
