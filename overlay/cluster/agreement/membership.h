// Who is there: what the peers' beacons say, whom the detector believes alive, whom the elector
// makes leader; and what the own beacon says about that.
//
// A link counts when it works both ways: a peer is alive to us when its beacons come here and say
// that ours reach it. Over one way only, it could not acknowledge our log or follow our view.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "election/elector.h"
#include "election/failure_detector.h"
#include "overlay/cluster/agreement/condition.h"
#include "overlay/cluster/envelope.h"
#include "overlay/cluster/options.h"
#include "overlay/cluster/times.h"
#include "romano/base/time.h"

namespace romano::cluster {

[[nodiscard]] inline election::NodeId node_of(BrokerId id) {
    return election::NodeId{static_cast<std::uint64_t>(id)};
}
[[nodiscard]] inline BrokerId broker_of(election::NodeId id) {
    return BrokerId{static_cast<std::uint64_t>(id)};
}

/// What is known of a peer: its newest beacon.
struct Peer {
    Beacon beacon;
    bool alive = false;
    Instant heard_at{};  // its last beacon or pulse
    bool ended = false;  // it said goodbye, or its process is gone; it did not just fall silent
    [[nodiscard]] bool is_home_of(const Endpoint& address) const {
        return std::ranges::count(beacon.home_addresses, address) > 0;
    }
    [[nodiscard]] bool is_serving(const Endpoint& address) const {
        return std::ranges::count(beacon.serving, address) > 0;
    }
    /// Not at its own address while another one serves that yet: it waits there for the sessions.
    [[nodiscard]] bool speaks_at(const Endpoint& address) const {
        return is_serving(address) && std::ranges::count(beacon.binding, address) == 0;
    }
    /// It follows that log, which ends there now: what is said in it reaches the peer.
    [[nodiscard]] bool follows(const broker::LogPosition& end) const {
        return end.seq == 0 || beacon.applied_through(end.log) > 0;
    }
};

class Membership {
public:
    Membership(const ClusterOptions& options, BrokerId self, std::uint64_t seed);

    /// A new life of this broker: it listens before it leads, as after its start.
    void restart();

    enum class Heard : std::uint8_t {
        nothing,  // of an earlier life of the peer, or our own
        life,     // and what changes all the time
        news,     // others act on it
    };
    Heard on_beacon(Instant now, const Beacon& beacon);
    /// A heartbeat of that log came. `join` brings its last beacon up to date, or is given null
    /// where none is known; it says whether that was done.
    using Join = std::function<bool(Beacon* last)>;
    Heard on_heartbeat(Instant now, const LogId& log, const Join& join);
    /// A pulse is a sign of life of those who are alive; the next beacon tells the rest.
    void on_pulse(Instant now, const Pulse& pulse);
    /// The leader's claim comes with its proposals too, and may come there before its beacon. Not
    /// in raft: terms are voted, and only beacons tell of them.
    void on_leader(Instant now, BrokerId leader, election::Term term);
    /// A view left it out, perhaps before our detectors noticed. It is gone until its next beacon;
    /// but when its last one is so young that it lives, it is still heard.
    void on_left_out(Instant now, const LogId& log);
    /// News of the link to a peer's process. False when it is another process by now.
    bool on_link(Instant now, const LogId& process, election::Link link);
    void on_ballot(Instant now, BrokerId from, const election::Ballot& ballot);
    void on_tick(Instant now);
    /// Battery or load of this broker, from 0 to 100.
    void on_condition(Instant now, std::uint32_t reading);
    /// What the elector has to say since the last call.
    void send_ballots(Outbox& out);
    /// The elector's next wish; detectors count beacon times.
    [[nodiscard]] Instant next_wakeup() const { return elector_->next_wakeup(); }

    /// Fills in what the own beacon says about the others.
    void describe(Beacon& beacon) const;

    [[nodiscard]] const std::map<BrokerId, Peer>& peers() const { return peers_; }
    /// Null when unknown.
    [[nodiscard]] const Peer* find(BrokerId id) const;
    /// Its beacons come here, whether or not ours reach it.
    [[nodiscard]] bool is_heard(BrokerId id) const { return heard_->is_alive(node_of(id)); }
    /// The beacons of this life come here.
    [[nodiscard]] bool is_heard(const LogId& log) const;
    /// Somebody's heartbeats come here, or came before it fell silent, of whom nothing else is
    /// known yet.
    [[nodiscard]] bool heard_unknown(Instant now) const;
    /// The peer is alive, and in this life.
    [[nodiscard]] bool is_alive(const LogId& log) const;
    /// Of the members that are alive and of which `is_one` holds: the address's own broker, else
    /// the highest.
    template <typename IsOne>
    [[nodiscard]] std::optional<LogId> server_of(const Endpoint& address, const View& view,
                                                 IsOne&& is_one) const {
        std::optional<LogId> server;
        for (const LogId& member : view.members) {
            if (!is_alive(member)) continue;
            const Peer& peer = *find(member.broker);
            if (!is_one(peer)) continue;
            if (peer.is_home_of(address)) return member;
            server = member;
        }
        return server;
    }
    /// Its last sign of life is much younger than a silence that means death.
    [[nodiscard]] bool is_heard_clearly(const LogId& log, Instant now) const;
    /// That life of the broker is over for certain.
    [[nodiscard]] bool has_ended(const LogId& log) const;
    [[nodiscard]] election::Leadership leadership() const { return elector_->leadership(); }
    [[nodiscard]] bool leads() const;
    /// Battery or load of this broker, as its rank has it.
    [[nodiscard]] std::uint32_t condition() const { return condition_.told(); }
    /// The peer's name, as its beacons say it; empty when unknown.
    [[nodiscard]] std::string name_of(BrokerId id) const;
    /// Grows whenever somebody else is alive, or in another life.
    [[nodiscard]] std::uint64_t changes() const { return changes_; }
    /// Grows also whenever somebody else is heard, or says something else that others act on.
    [[nodiscard]] std::uint64_t news() const { return news_; }
    /// Peers that were taken for dead since the last call.
    [[nodiscard]] std::vector<BrokerId> take_lost();
    [[nodiscard]] Duration detection_time() const { return linked_->detection_time(); }
    [[nodiscard]] Times times() const { return options_.times(detection_time()); }

private:
    /// What others act on, of what heartbeats tell.
    struct News {
        ViewNumber view{};
        election::Claim claim{};
        bool leaving = false;
        bool hears_us = false;

        friend bool operator==(const News&, const News&) = default;
    };
    [[nodiscard]] News news_of(const Beacon& beacon) const;
    [[nodiscard]] static bool is_news(const Beacon& before, const Beacon& beacon);
    Heard on_tick_of(Instant now, Peer& peer, bool has_news);
    Heard heard(bool has_news);
    void bury_suspects(Instant now);
    [[nodiscard]] bool was_heard_just_now(const Peer& peer, Instant now) const;

    ClusterOptions options_;
    BrokerId self_;
    std::uint64_t seed_;
    Condition condition_;
    std::unique_ptr<election::FailureDetector> heard_;   // beacons come here
    std::unique_ptr<election::FailureDetector> linked_;  // and ours go there
    std::unique_ptr<election::Elector> elector_;
    std::map<BrokerId, Peer> peers_;
    std::map<LogId, Instant> unknown_;  // of whom no beacon is known: heard at
    std::vector<BrokerId> lost_;
    std::uint64_t changes_ = 0;
    std::uint64_t news_ = 0;
};

}  // namespace romano::cluster
