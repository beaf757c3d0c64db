// Beacons in two parts: what is said every beacon interval, and what changes rarely.
//
// A beacon that says everything grows with the number of brokers, and everybody hears everybody's:
// with a hundred brokers that was the whole traffic. So a heartbeat says what is new. Members of
// one view name each other by their places in it, in one bit. How far a log is held is said in
// three heartbeats when it has changed, and of a few logs in turn: whoever lost those three has it
// some heartbeats later. What a heartbeat cannot tell to one who has lost something, or is new, it
// makes known by a digest, a view number and a count; that one asks for the particulars.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "overlay/cluster/messages.h"
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

    static constexpr std::uint64_t said_in = 3;  // heartbeats: what has changed
    static constexpr std::size_t repeated = 4;   // logs that have not, in turn
    static constexpr std::uint64_t octets_told_every =
        64;  // heartbeats: what the transport carried

private:
    struct Said {
        Seq through = 0;
        std::uint64_t changed_at = 0;  // tick
    };

    std::map<LogId, Said> held_;
    std::optional<LogId> repeated_last_;
    std::uint32_t particulars_ = 0;
    bool has_news_ = false;
};

/// Puts the peers' beacons together.
class HeartbeatReader {
public:
    explicit HeartbeatReader(BrokerId self) : self_(self) {}

    /// The peer's newest beacon, as far as it is known; null while its particulars are not here,
    /// and when it was heard before. Valid until the next call. A sender in `own_view` needs not
    /// say who is in it.
    /// `own_tick`: the newest that the sender may have heard.
    [[nodiscard]] const Beacon* read(const Heartbeat& heartbeat, const View& own_view,
                                     std::uint64_t own_tick);
    /// The same. Null when they are old, or no heartbeat of that log was heard yet.
    [[nodiscard]] const Beacon* read(const Particulars& particulars, const View& own_view);
    /// Something is lacking that only the particulars tell, and it was not asked for just now.
    [[nodiscard]] bool must_ask(Instant now, Duration again_after, BrokerId peer);

    /// All that the peer's newest heartbeat speaks of is known.
    [[nodiscard]] bool is_complete(BrokerId peer) const;

    static constexpr std::size_t peers_most = 1'000;  // beyond it, all are asked anew
    static constexpr std::size_t logs_most = 4'000;   // a peer; the rest counts as not held

private:
    struct Peer {
        Heartbeat heartbeat;
        std::optional<Beacon> beacon;  // of that log
        std::uint32_t particulars = 0;
        bool lacks_view = false;
        std::uint64_t counts_differ_since = 0;  // tick; 0: they do not
        std::optional<Instant> asked_at;
        std::optional<Echo> echo;  // of us
        bool lacks_echo = false;

        [[nodiscard]] bool lacks_something() const;
    };

    [[nodiscard]] const Beacon* join(Peer& peer, const View& own_view) const;
    void join_view(Peer& peer, const View& own_view) const;
    void join_echo(Peer& peer, std::uint64_t own_tick) const;
    [[nodiscard]] Peer* find_or_add(const LogId& log);

    BrokerId self_;
    std::map<BrokerId, Peer> peers_;
};

}  // namespace romano::cluster
