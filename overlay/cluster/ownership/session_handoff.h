// Sessions on their way from one live home to another: sent in parts, adopted when the last part is
// there and none is missing, acknowledged when the adoption is safe with peers. Until then the
// sender keeps them. Many are adopted in pieces. What their clients publish here comes after what
// their former home had worked through: they wait for that, but for no longer than a snapshot takes
// to come.
#pragma once

#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/adoption.h"

namespace romano::cluster {

/// All sessions of one service address, or with `address` none: one session that roams.
void send_handoff(const LogId& to, const Endpoint& address,
                  std::vector<broker::SessionImage> sessions, Outbox& out);

/// Some of them, from part number `part` on. `last`: no more follow. Returns the next part's
/// number.
std::uint32_t send_handoff_piece(const LogId& to, const Endpoint& address, std::uint32_t part,
                                 std::vector<broker::SessionImage> sessions, bool last,
                                 Outbox& out);

class HandoffReceiver {
public:
    explicit HandoffReceiver(std::size_t sessions_per_turn)
        : sessions_per_turn_(sessions_per_turn) {}

    /// From whom all sessions of an address are adopted now.
    struct Adopted {
        BrokerId from;
        Endpoint address;
    };

    /// `is_refused`: they are acknowledged and not adopted; their clients must connect anew.
    void on_handoff(const Effects& effects, BrokerId from, SessionHandoff part, bool is_refused);
    /// They were called off, and live on where they came from.
    void forget_waiting();
    /// Looks who need not wait any more.
    using IsWorkedThrough = std::function<bool(const LogPosition&)>;
    void heed(Instant now, const IsWorkedThrough& is_worked_through);
    /// A new turn: adopts some of those that wait for nothing.
    void on_turn(Effects& effects, const Logs& logs);
    /// Since the last call.
    [[nodiscard]] std::vector<Adopted> take_adopted() { return std::exchange(adopted_, {}); }
    /// The client's session is here, and waits to be adopted.
    [[nodiscard]] bool holds(const broker::ClientId& client) const;
    /// There is something for the next turn.
    [[nodiscard]] bool is_half_done() const;
    /// Sends the acknowledgements that the safe watermark allows.
    void carry_on(Effects& effects, Seq safe);

private:
    struct Incoming {
        std::uint32_t next_part = 0;
        std::vector<broker::SessionImage> sessions{};
        std::vector<LogPosition> after{};  // by log
    };
    struct Arrived {
        BrokerId from;
        HandoffAck ack;
        std::vector<broker::SessionImage> sessions;
        std::vector<LogPosition> after;  // by log
        Instant until;
        bool is_refused = false;
        std::size_t adopted = 0;
    };
    struct WaitingAck {
        Seq after;  // the last SessionPut of the adoption
        BrokerId to;
        HandoffAck ack;
    };

    /// True when all are.
    bool adopt_some(Effects& effects, const Logs& logs, Arrived& arrived);

    std::size_t sessions_per_turn_;
    // Bounded: one hand-over an address and peer; its size is the sender's own limit of sessions.
    std::map<std::pair<BrokerId, Endpoint>, Incoming> incoming_;
    std::vector<Arrived> arrived_;  // whole, and not all adopted
    std::vector<Adopted> adopted_;
    std::vector<WaitingAck> acks_;
};

}  // namespace romano::cluster
