// Beacons in two parts: what is said every beacon interval, and what changes rarely.
//
// A beacon that says everything grows with the number of brokers, and everybody hears everybody's:
// with a hundred brokers that was the whole traffic. So a heartbeat says what is new. Members of
// one view name each other by their places in it, in one bit. How far a log is held is said in
// three heartbeats when it has changed, and of a few logs in turn: whoever lost those three has it
// some heartbeats later. By a digest, a view number and a count a heartbeat shows a reader that it
// lacks something, for it lost a heartbeat or is new; that reader asks for the particulars.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "overlay/cluster/messages.h"
#include "romano/base/flat_map.h"
#include "romano/base/time.h"

namespace romano::cluster {

/// Of what only the particulars say, and of the addresses that the broker serves.
[[nodiscard]] std::uint32_t digest_of_particulars(const Beacon& beacon);

/// Says the own beacon.
class HeartbeatWriter {
public:
    /// The beacon is the next one; its tick is one higher than the last one's.
    [[nodiscard]] Heartbeat write(const Beacon& beacon);
    /// The particulars changed with the last beacon that was written: all peers should have them.
    [[nodiscard]] bool has_news() const { return has_news_; }

    static constexpr std::uint64_t said_in = 3;            // heartbeats: what has changed
    static constexpr std::size_t repeated = 4;             // logs that have not, in turn
    static constexpr std::uint64_t usage_told_every = 64;  // heartbeats

private:
    struct Said {
        Seq through = 0;
        std::uint64_t changed_at = 0;  // tick
    };

    FlatMap<LogId, Said> held_;
    std::optional<LogId> repeated_last_;
    std::uint32_t particulars_ = 0;
    bool has_news_ = false;
};

/// Puts the peers' beacons together. The caller keeps the newest one of each peer: brokers that
/// hear a hundred of them should find each in one place.
class HeartbeatReader {
public:
    explicit HeartbeatReader(BrokerId self) : self_(self) {}

    /// Brings `last` up to date, the newest beacon of that log that is known: null while its
    /// particulars are not here. False when the heartbeat is older. A sender in `own_view` needs
    /// not say who is in it.
    /// `own_tick`: the newest that the sender may have heard.
    [[nodiscard]] bool read(const Heartbeat& heartbeat, Beacon* last, const View& own_view,
                            std::uint64_t own_tick);
    /// The beacon that particulars are with what heartbeats said since. None when they are old, or
    /// no heartbeat of that log was heard yet.
    [[nodiscard]] std::optional<Beacon> read(const Particulars& particulars, const Beacon* last,
                                             const View& own_view);
    /// Something is lacking that only the particulars tell, and it was not asked for just now.
    [[nodiscard]] bool must_ask(Instant now, Duration again_after, BrokerId peer);

    /// All that the peer's newest heartbeat speaks of is known.
    [[nodiscard]] bool is_complete(BrokerId peer) const;

    static constexpr std::size_t peers_most = 1'000;  // beyond it, all are asked anew
    static constexpr std::size_t logs_most = 4'000;   // a peer; the rest counts as not held

private:
    struct Peer {
        Heartbeat heartbeat;
        bool is_known = false;  // a beacon of that log is
        /// Whom it hears and vouches for stands in that beacon as the heartbeat has it.
        bool is_joined = false;
        std::uint32_t particulars = 0;
        bool lacks_view = false;
        std::uint64_t counts_differ_since = 0;  // tick; 0: they do not
        std::optional<Instant> asked_at;
        std::optional<Echo> echo;  // of us
        bool lacks_echo = false;

        [[nodiscard]] bool lacks_something() const;
    };

    void join(Peer& peer, Beacon& beacon, const View& own_view) const;
    void join_view(Peer& peer, Beacon& beacon, const View& own_view) const;
    void join_echo(Peer& peer, Beacon& beacon, const View& own_view, std::uint64_t own_tick) const;
    static void join_hears(Peer& peer, Beacon& beacon);
    [[nodiscard]] Peer* find_or_add(const LogId& log);

    BrokerId self_;
    std::map<BrokerId, Peer> peers_;
};

}  // namespace romano::cluster
