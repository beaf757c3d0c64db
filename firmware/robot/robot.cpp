#include "firmware/robot/robot.h"

#include <algorithm>
#include <array>

#include "firmware/robot/address.h"

namespace romano::firmware {
RobotCore::RobotCore(client::ClientCore& client, client::Output& scratch,
                     const RobotSettings& settings, const romano_board& board,
                     Controller& controller)
    : board_(board),
      controller_(controller),
      node_(client, scratch, mailbox_, settings.node),
      discovers_(settings.broker.family == Endpoint::Family::none),
      choice_(settings.seed) {
    now_ = now();
    if (discovers_) {
        choice_.search(now_);
    } else {
        broker_ = settings.broker;
    }
}

Instant RobotCore::now() const {
    return Instant{to_duration(std::chrono::milliseconds{board_.now_ms(board_.self)})};
}

std::optional<int> RobotCore::link_dbm(const romano_address& peer) const {
    if (board_.link_dbm == nullptr) return std::nullopt;
    const int dbm = board_.link_dbm(board_.self, &peer);
    return dbm == ROMANO_LINK_UNKNOWN ? std::nullopt : std::optional{dbm};
}

Instant RobotCore::run() {
    now_ = now();
    receive_all();
    if (is_leaving_) {
        if (node_.next_wakeup() <= now_) node_.on_tick(now_, *this);
        return node_.next_wakeup();
    }
    if (discovers_) choose_broker();
    if (!broker_) return std::min(choice_.next_wakeup(), choice_.decides_at());
    if (node_.phase() == node::Phase::stopped) node_.start(now_, *this);
    if (node_.next_wakeup() <= now_) node_.on_tick(now_, *this);
    if (!discovers_) return node_.next_wakeup();
    const Instant next =
        std::min(std::min(node_.next_wakeup(), choice_.next_wakeup()), silence_ends_at());
    return choice_.decides_at() > now_ ? std::min(next, choice_.decides_at()) : next;
}

void RobotCore::leave() {
    now_ = now();
    is_leaving_ = true;
    node_.leave(now_, *this);
}

void RobotCore::receive_all() {
    romano_address from{};
    std::uint32_t size = 0;
    while (const std::uint8_t* octets = board_.receive(board_.self, &from, &size)) {
        const Endpoint sender = endpoint_of(from);
        const Bytes datagram{octets, size};
        if (discovers_) choice_.on_datagram(now_, sender, datagram, link_dbm(from));
        if (sender != broker_) continue;
        forgive_silence();
        node_.on_datagram(now_, datagram, *this);
    }
}

void RobotCore::choose_broker() {
    const std::uint32_t losses = node_.counters().connections_lost;
    if (broker_ && losses != losses_seen_) {
        choice_.abandon(now_, *broker_);
        broker_.reset();
    }
    losses_seen_ = losses;
    heed_silence();
    std::array<std::uint8_t, BrokerChoice::largest_datagram> search{};
    if (const std::size_t size = choice_.on_tick(now_, search)) {
        const romano_address everybody{};
        board_.send(board_.self, &everybody, search.data(), static_cast<std::uint32_t>(size));
    }
    // A session follows its client from broker to broker of one cluster: nothing is begun anew.
    auto nearest = choice_.choose(now_, is_broker_silent_ ? std::nullopt : broker_);
    if (is_broker_silent_ && !nearest) nearest = broker_;
    if (broker_ && nearest != broker_) {
        node_.on_broker_changed(now_);
        forgive_silence();
    }
    broker_ = nearest;
}

Instant RobotCore::silence_ends_at() const {
    return unanswered_since_ == never ? never : unanswered_since_ + silence;
}

void RobotCore::forgive_silence() {
    unanswered_since_ = never;
    is_probing_ = false;
    is_broker_silent_ = false;
}

void RobotCore::heed_silence() {
    if (!broker_ || now_ < silence_ends_at()) return;
    unanswered_since_ = now_;
    if (is_probing_) {
        is_broker_silent_ = true;
        choice_.abandon(now_, *broker_);
    }
    is_probing_ = true;
    node_.probe(now_);
}

void RobotCore::send(Bytes datagram) {
    if (!broker_) return;
    unanswered_since_ = std::min(unanswered_since_, now_);
    const romano_address to = address_of(*broker_);
    board_.send(board_.self, &to, datagram.data(), static_cast<std::uint32_t>(datagram.size()));
}

bool RobotCore::subscribe(std::string_view topic) {
    return node_.subscribe(now_, topic, *this);
}
bool RobotCore::request_connected_nodes() {
    return node_.request_connected_nodes(now_, *this);
}

}  // namespace romano::firmware
