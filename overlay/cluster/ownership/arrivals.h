// Sessions that their former homes moved here (broker::SessionMoved, in the logs of those) are
// adopted from the mirrors of these logs, many in pieces. The SessionPut of the adoption names the
// event that it answers. A session of which another home has a higher copy goes on there (I7). What
// a client publishes here comes after what its former home had worked through: the session waits
// for that, but for no longer than a snapshot takes to come.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/adoption.h"
#include "overlay/cluster/ownership/departures.h"

namespace romano::cluster {

class Arrivals {
public:
    Arrivals(const LogId& self, std::size_t sessions_per_turn)
        : self_(self), sessions_per_turn_(sessions_per_turn) {}

    /// All sessions of the address that `from` had are here now.
    struct Settled {
        BrokerId from;
        Endpoint address;
    };

    /// The event has just been applied.
    void on_event(const Effects& effects, const PeerLog& log, const broker::LogEvent& event);
    /// A snapshot brought the sessions that this log moved here.
    void on_snapshot(const Effects& effects, const PeerLog& log);
    /// The log has ended: what it moved here and called off counts again, for nobody takes it
    /// back.
    void on_end(const Effects& effects, const PeerLog& log);
    /// We stood still: their homes called them off, or will.
    void forget_waiting(const PeerLogs& logs);
    /// Looks who need not wait any more.
    using IsWorkedThrough = std::function<bool(const LogPosition&)>;
    void heed(Instant now, const IsWorkedThrough& is_worked_through);
    /// A new turn: the next carry_on() may adopt many.
    void on_turn() { allowed_ = sessions_per_turn_; }
    /// Returns what is settled now. `home_of_higher`: of a copy that outranks the one that comes
    /// (settlement.h).
    using HomeOfHigher = std::function<std::optional<LogId>(const broker::SessionHeader&)>;
    [[nodiscard]] std::vector<Settled> carry_on(Effects& effects, const Logs& logs,
                                                const HomeOfHigher& home_of_higher,
                                                Departures& departures);
    /// The client's session is here, and waits to be adopted.
    [[nodiscard]] bool holds(const broker::ClientId& client) const;
    /// There is something for the next turn.
    [[nodiscard]] bool is_half_done() const { return is_half_done_; }

private:
    struct Arrival {
        LogPosition moved;
        broker::ClientId client;         // empty: all of the address have come
        Endpoint address = {};           // then
        std::vector<LogPosition> after;  // by log
        Instant until;
    };

    void put(const Effects& effects, const LogId& from, const MovedSession& session);

    LogId self_;
    std::size_t sessions_per_turn_;
    std::size_t allowed_ = 0;
    bool is_half_done_ = false;
    std::vector<Arrival> arrivals_;    // of each log in its order
    std::map<LogId, Seq> called_off_;  // what was moved by the events up to there
};

}  // namespace romano::cluster
