#include "overlay/member/held_output.h"

#include <algorithm>

namespace romano::overlay {
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

void HeldOutput::release(broker::Seq safe, broker::Actions& out) {
    while (!waiting_.empty() && waiting_.begin()->first <= safe) {
        const Datagram& datagram = waiting_.begin()->second;
        std::ranges::copy(datagram.octets, out.reserve(datagram.octets.size()).begin());
        out.push(broker::Send{.via = datagram.via,
                              .to = datagram.to,
                              .offset = out.commit(datagram.octets.size()),
                              .size = static_cast<std::uint32_t>(datagram.octets.size())});
        octets_ -= datagram.octets.size() + overhead;
        waiting_.erase(waiting_.begin());
    }
}

void HeldOutput::drop(const Endpoint& via) {
    std::erase_if(waiting_, [&](const auto& entry) {
        if (entry.second.via != via) return false;
        octets_ -= entry.second.octets.size() + overhead;
        return true;
    });
}

void HeldOutput::clear() {
    waiting_.clear();
    octets_ = 0;
}

std::set<Endpoint> HeldOutput::addresses() const {
    std::set<Endpoint> found;
    for (const auto& [after, datagram] : waiting_) found.insert(datagram.via);
    return found;
}

}  // namespace romano::overlay
