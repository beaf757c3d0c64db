#include "overlay/cluster/speaking/cut_off.h"

#include "romano/mqttsn/frame.h"
#include "romano/mqttsn/types.h"

namespace romano::cluster {
namespace {

/// Whether the client may have had it from another broker.
bool may_be_repetition(CutOff::Address from, Bytes datagram) {
    auto frame = mqttsn::decode_frame(datagram);
    if (frame && !frame->wrapped.empty()) frame = mqttsn::decode_frame(frame->wrapped);
    if (!frame) return false;
    if (frame->type == mqttsn::MsgType::pubrel) return true;
    if (frame->type != mqttsn::MsgType::publish || frame->body.empty()) return false;
    const mqttsn::Flags flags = mqttsn::flags_from_wire(frame->body[0]);
    const bool is_taken_over = from == CutOff::Address::taken_over;
    return flags.dup || (is_taken_over && flags.qos == mqttsn::Qos::exactly_once);
}

}  // namespace

bool CutOff::on_view(Instant now, const View& view, const Judgement& has_ended,
                     const Judgement& is_heard) {
    const bool was_in_doubt = is_in_doubt();
    if (view.number != seen_ && !view.members.empty()) see(now, view, has_ended);
    std::erase_if(awaited_, [&](const broker::LogId& member) {
        return now >= awaited_until_ || has_ended(member) || is_heard(member);
    });
    return was_in_doubt && !is_in_doubt();
}

void CutOff::see(Instant now, const View& view, const Judgement& has_ended) {
    seen_ = view.number;
    const bool is_first = members_.empty();
    const bool was_possible = is_possible();
    missing_.merge(members_);
    members_ = {view.members.begin(), view.members.end()};
    std::erase_if(missing_, [&](const broker::LogId& member) {
        return members_.contains(member) || has_ended(member);
    });
    std::erase_if(awaited_, [&](const auto& member) { return !members_.contains(member); });
    if (was_possible && is_possible()) return;
    served_from_.clear();
    if (!is_possible() || now >= near_until_) near_.clear();
    if (is_possible()) return awaited_.clear();
    missing_.clear();
    if (!was_possible && !is_first) return;
    awaited_ = members_;
    awaited_until_ = now + others_come_within_;
}

void CutOff::on_heard_in_doubt(Instant now, const Way& client) {
    if (is_possible()) return;
    if (now >= near_until_) near_.clear();
    near_until_ = now + others_come_within_;
    if (near_.size() < heard_most) near_.insert(client);
}

bool CutOff::must_wait(Instant now, const Way& client) {
    if (!awaited_.empty()) return true;
    if (!is_possible()) return false;
    auto heard = served_from_.find(client);
    if (heard == served_from_.end()) {
        if (served_from_.size() == heard_most) return false;
        heard = served_from_.emplace(client, now + others_come_within_).first;
    }
    return now < heard->second && !near_.contains(client);
}

bool CutOff::withholds(Instant now, Address from, const Way& client, Bytes datagram) const {
    if (!awaited_.empty()) return true;
    if (!is_possible() || !may_be_repetition(from, datagram)) return false;
    const auto heard = served_from_.find(client);
    return heard == served_from_.end() || now < heard->second;
}

}  // namespace romano::cluster
