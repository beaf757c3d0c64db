// What is missing here of the peers' logs, and asked for (Fetch): at once where nothing is held of
// a log or a view is new, else when it was missing for a moment; and again, of the next who holds
// it, while nothing comes. Each piece that comes asks for the next one.
//
// A peer that lives is asked for what follows a gap in its log. Members are asked for what removed
// brokers wrote last: a newcomer may be home to subscribers when a broker dies of whose log it
// holds nothing, and who was cut off may lack more than others keep. Publishes are enough then, for
// the own sessions; but an heir goes on from events alone.
//
// And deliveries of a peer's sessions may name messages that came from nowhere: they were published
// at a broker that came and died while this one was away. The home of these sessions is asked for
// a snapshot when they have been missing for long; most come a moment later, with their
// publisher's log. Of a log that ended before this broker came nothing comes by itself: that home
// is asked for its publishes at once, for until they are here what names them is not acknowledged.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/replication/peer_log.h"

namespace romano::cluster {

class Fetching {
public:
    explicit Fetching(BrokerId self) : self_(self) {}

    void on_view(const ViewAnnouncement& announcement);
    /// `inherits`: we are to go on from that log.
    using Inherits = std::function<bool(const LogId&)>;
    void carry_on(Effects& effects, const PeerLogs& logs, const Membership& membership,
                  const View& view, const Inherits& inherits);
    /// That peer sent so many events of the log. Of a full batch there may be more, and the next is
    /// asked for; with fewer it has sent all that it had, and newer ones are on their way. On a
    /// slow network each of these would otherwise be asked for, and all that follows be sent again.
    void on_events(Effects& effects, BrokerId from, const PeerLogs::value_type& log,
                   std::size_t events);
    /// The next part of a snapshot of a living peer's log is here.
    void on_part(Instant now, const LogId& log) { waits_[log].since = now; }
    /// Of a removed one's. False when that member was not asked for it last, or it does not follow
    /// what came: two members may hold different ones.
    bool on_last_publishes(Instant now, BrokerId from, const SnapshotPart& part);
    /// That event lies before the end of a removed log, and its publish is not here.
    [[nodiscard]] bool awaits(const LogPosition& event) const;

private:
    struct Wait {
        Instant since = Instant::min();
        Seq after = 0;     // is here
        BrokerId asked{};  // and has not sent all; 0: nobody
        int times_asked = 0;
    };
    struct Removed {
        Seq end = 0;
        std::uint32_t next_part = 0;
        bool has_publishes = false;  // up to the end
    };
    struct Missing {
        std::vector<LogPosition> messages;
        Instant since;
    };

    void ask(Effects& effects, const LogPosition& after, Instant missing_since, BrokerId holder);
    void ask_for_messages(Effects& effects, const PeerLogs::value_type& log, const PeerLogs& logs);
    void send(Effects& effects, Wait& wait, const LogPosition& after, BrokerId holder);
    [[nodiscard]] bool lacks(const PeerLogs::value_type& log) const;
    [[nodiscard]] std::optional<BrokerId> next_holder(const LogPosition& after,
                                                      const Membership& membership,
                                                      const View& view) const;

    BrokerId self_;
    std::map<LogId, Wait> waits_;       // of logs of which something is missing
    std::map<LogId, Removed> removed_;  // that are not all here
    std::map<LogId, Missing> missing_;  // by the log whose mirror lacks them
    bool is_new_view_ = false;
    Instant next_look_ = Instant::min();
};

}  // namespace romano::cluster
