#include "overlay/cluster/session_handoff.h"

#include <algorithm>
#include <iterator>

namespace romano::cluster {
namespace {

constexpr std::size_t sessions_per_part = 16;

}  // namespace

void send_handoff(BrokerId to, const Endpoint& address, std::vector<broker::SessionImage> sessions,
                  Outbox& out) {
    SessionHandoff part{.address = address};
    for (auto& image : sessions) {
        if (part.sessions.size() == sessions_per_part) {
            out.push_back({to, std::exchange(part, SessionHandoff{.address = address})});
        }
        part.sessions.push_back(std::move(image));
    }
    part.last = true;
    out.push_back({to, std::move(part)});
}

bool HandoffReceiver::on_handoff(Effects& effects, const Logs& logs, BrokerId from,
                                 SessionHandoff part) {
    auto& sessions = incoming_[{from, part.address}];
    std::ranges::move(part.sessions, std::back_inserter(sessions));
    if (!part.last) return false;
    const auto all = incoming_.extract({from, part.address});
    HandoffAck ack{.address = part.address};
    for (auto& image : all.mapped()) {
        if (part.address.family == Endpoint::Family::none) ack.client_id = image.header.client_id;
        adopt(effects, logs, std::move(image));
    }
    acks_.push_back({effects.broker.last_seq(), from, std::move(ack)});
    return true;
}

void HandoffReceiver::carry_on(Effects& effects, Seq safe) {
    std::erase_if(acks_, [&](WaitingAck& waiting) {
        if (waiting.after > safe) return false;
        effects.peers.push_back({waiting.to, std::move(waiting.ack)});
        return true;
    });
}

void HandoffReceiver::restart() {
    incoming_.clear();
    acks_.clear();
}

}  // namespace romano::cluster
