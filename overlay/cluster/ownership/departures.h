// Sessions that were moved from here to another home (broker::SessionMoved). This broker stops
// serving them with the event, so that two homes never speak to a client, and keeps them until the
// new home has them in its log. It takes back what does not get there: when the log of the new home
// has ended without it, as the view agreed, or the answer does not come.
//
// I7: a broker has one copy of a session: its own, or one on its way. What comes beside that is
// joined with it, as their ranks say (broker::settle), from wherever it comes.
#pragma once

#include <map>
#include <optional>

#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/adoption.h"

namespace romano::cluster {

class Departures {
public:
    explicit Departures(std::size_t sessions_per_turn) : sessions_per_turn_(sessions_per_turn) {}

    /// `epochs`: 1 when both homes want it, which is as good as being heard there; 0 when the ranks
    /// of two copies decide. A home with other predefined topics gets nothing: its client must
    /// connect anew.
    void move(Effects& effects, const broker::ClientId& client, const LogId& to,
              std::uint64_t epochs, const PeerLogs& logs);
    /// A session that was never here goes on to another home. A dead home's goes to the broker that
    /// serves its address; a living home's (`moved`) to the one whose copy outranks it. Readers of
    /// our log take it for as far worked through as we are, and so it is.
    void pass_on(Effects& effects, const Logs& logs, broker::SessionImage image, const LogId& to,
                 const std::optional<LogPosition>& moved = std::nullopt);
    /// The new home says that it has what the event `at` of the own log moved there.
    void on_arrived(const broker::ClientId& client, Seq at);
    /// The session comes here. `moved`: the event by which its living home said so.
    void adopt(Effects& effects, const Logs& logs, broker::SessionImage image,
               const std::optional<LogPosition>& moved = std::nullopt);
    /// Our copy is on its way to the broker of the log from which this one comes, and outranks it:
    /// the two are joined there.
    [[nodiscard]] bool crosses(const MovedSession& comes, const LogId& from) const;
    /// Takes back what did not get there; in pieces.
    void carry_on(Effects& effects, const Logs& logs, const View& view);
    /// There is more to take back.
    [[nodiscard]] bool is_half_done() const { return is_half_done_; }
    /// A session of the client at that address may come back: what it says waits.
    [[nodiscard]] bool is_leaving(const Endpoint& client) const {
        return speaking_from_.contains(client);
    }
    [[nodiscard]] bool has_any_via(const Endpoint& address) const { return via_.contains(address); }
    /// How many are on their way there.
    [[nodiscard]] std::size_t to(const LogId& home) const {
        const auto found = to_.find(home);
        return found == to_.end() ? 0 : found->second;
    }
    /// That home does not answer for some sessions: carry_on() takes them back.
    [[nodiscard]] bool has_late_ones(const Effects& effects, const LogId& to) const;
    struct Leaving {
        MovedSession session;
        std::uint64_t epochs;
        Instant since;
    };
    [[nodiscard]] const std::map<broker::ClientId, Leaving>& all() const { return leaving_; }

private:
    /// Ends the client's departure, and returns the copy that was on its way, if there is one.
    [[nodiscard]] std::optional<broker::SessionImage> call_off(const broker::ClientId& client);
    void put(Effects& effects, broker::SessionImage image, const LogId& to, std::uint64_t epochs);
    Leaving take(std::map<broker::ClientId, Leaving>::iterator leaving);

    std::size_t sessions_per_turn_;
    bool is_half_done_ = false;
    std::map<broker::ClientId, Leaving> leaving_;
    std::map<Endpoint, std::size_t> speaking_from_;  // so many of them
    std::map<Endpoint, std::size_t> via_;
    std::map<LogId, std::size_t> to_;
    Instant oldest_{};  // none has left before
};

}  // namespace romano::cluster
