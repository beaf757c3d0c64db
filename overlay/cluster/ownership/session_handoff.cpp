#include "overlay/cluster/ownership/session_handoff.h"

#include <algorithm>
#include <iterator>

#include "broker/core/cursors.h"

namespace romano::cluster {
namespace {

constexpr std::size_t sessions_per_handoff_part = 16;

}  // namespace

void send_handoff(const LogId& to, const Endpoint& address,
                  std::vector<broker::SessionImage> sessions, Outbox& out) {
    (void)send_handoff_piece(to, address, 0, std::move(sessions), true, out);
}

std::uint32_t send_handoff_piece(const LogId& to, const Endpoint& address, std::uint32_t part,
                                 std::vector<broker::SessionImage> sessions, bool last,
                                 Outbox& out) {
    SessionHandoff message{.to = to, .address = address, .part = part};
    for (auto& image : sessions) {
        if (message.sessions.size() == sessions_per_handoff_part) {
            SessionHandoff following{.to = to, .address = address, .part = ++part};
            out.push_back({to.broker, std::exchange(message, std::move(following))});
        }
        message.sessions.push_back(std::move(image));
    }
    message.last = last;
    out.push_back({to.broker, std::move(message)});
    return part + 1;
}

void HandoffReceiver::on_handoff(const Effects& effects, BrokerId from, SessionHandoff part,
                                 bool is_refused) {
    const std::pair key{from, part.address};
    if (part.part == 0) incoming_[key] = {};  // an earlier one was called off
    const auto found = incoming_.find(key);
    if (found == incoming_.end()) return;
    Incoming& incoming = found->second;
    if (part.part != incoming.next_part++) {
        incoming_.erase(found);  // some are lost: without an answer it begins anew
        return;
    }
    for (const broker::SessionImage& image : part.sessions) {
        incoming.after = broker::later_of(incoming.after, image.worked_through);
    }
    std::ranges::move(part.sessions, std::back_inserter(incoming.sessions));
    if (!part.last) return;
    Arrived arrived{.from = from,
                    .ack = {.address = part.address},
                    .sessions = std::move(incoming.sessions),
                    .after = std::move(incoming.after),
                    .until = effects.now + effects.times.former_home_waited_for(),
                    .is_refused = is_refused};
    incoming_.erase(found);
    arrived_.push_back(std::move(arrived));
}

void HandoffReceiver::forget_waiting() {
    incoming_.clear();
    std::erase_if(arrived_, [](const Arrived& arrived) { return arrived.adopted == 0; });
}

void HandoffReceiver::heed(Instant now, const IsWorkedThrough& is_worked_through) {
    for (Arrived& arrived : arrived_) {
        if (now >= arrived.until) arrived.after.clear();
        std::erase_if(arrived.after, is_worked_through);
    }
}

void HandoffReceiver::on_turn(Effects& effects, const Logs& logs) {
    std::erase_if(arrived_, [&](Arrived& arrived) {
        return arrived.after.empty() && adopt_some(effects, logs, arrived);
    });
}

bool HandoffReceiver::holds(const broker::ClientId& client) const {
    return std::ranges::any_of(arrived_, [&client](const Arrived& arrived) {
        return std::ranges::any_of(arrived.sessions, [&client](const auto& image) {
            return image.header.client_id == client;
        });
    });
}

bool HandoffReceiver::is_half_done() const {
    return std::ranges::any_of(arrived_,
                               [](const Arrived& arrived) { return arrived.after.empty(); });
}

bool HandoffReceiver::adopt_some(Effects& effects, const Logs& logs, Arrived& arrived) {
    auto& [from, ack, sessions, after, until, is_refused, adopted] = arrived;
    const std::size_t end = std::min(adopted + sessions_per_turn_, sessions.size());
    for (; adopted < end; ++adopted) {
        broker::SessionImage& image = sessions[adopted];
        if (ack.address.family == Endpoint::Family::none) ack.client_id = image.header.client_id;
        if (!is_refused) adopt(effects, logs, std::move(image));
    }
    if (adopted < sessions.size()) return false;
    adopted_.push_back({from, ack.address});
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

}  // namespace romano::cluster
