#include "overlay/cluster/speaking/held_output.h"

namespace romano::cluster {
namespace {

constexpr std::size_t octets_most = 64U << 20U;
constexpr std::size_t overhead = 128;  // of one datagram in the queue

}  // namespace

void HeldOutput::hold(const broker::Send& send, Bytes octets) {
    if (octets_ + octets.size() + overhead > octets_most) {
        ++dropped_;
        return;
    }
    octets_ += octets.size() + overhead;
    waiting_.emplace(send.after, Datagram{send.via, send.to, {octets.begin(), octets.end()}});
}

void HeldOutput::send(const Datagram& datagram, broker::Actions& out) {
    out.push(broker::Send{.via = datagram.via, .to = datagram.to}, datagram.octets);
}

HeldOutput::Waiting::iterator HeldOutput::erase(Waiting::iterator datagram) {
    octets_ -= datagram->second.octets.size() + overhead;
    return waiting_.erase(datagram);
}

void HeldOutput::clear() {
    waiting_.clear();
    detained_.clear();
    octets_ = 0;
    is_behind_ = false;
}

std::set<Endpoint> HeldOutput::addresses() const {
    std::set<Endpoint> found;
    for (const auto& [after, datagram] : waiting_) found.insert(datagram.via);
    return found;
}

}  // namespace romano::cluster
