// Who may speak at an address, and decide about it: a member that holds a lease.
//
// Every heartbeat echoes the newest tick that its sender heard of each member: so the member named
// knows that at that tick it was still in its place there. It holds its lease while more than half
// of its view, itself included, echoed ticks younger than a term, and every member one younger
// than three; of two members both echo within a term. Terms are shorter for the holder than for
// those who wait, for clocks are slewed and what leaves takes a moment. Where two members do
// not hear each other, a third one that vouches for both says so: what it says of another one is a
// term old.
//
// Whoever is about to promise a view without a member echoes it no more, and promises when that
// one's lease must have run out: a term after the last tick that it echoed, or three when the view
// keeps less than half of one that it promised before. From that promise it does not echo the
// member again before it installs a view with it. So two that speak at one address are in views
// without a common member (invariant I1). The model in overlay/cluster/model has these sentences,
// and shows what breaks when one is missing.
//
// Who stood still for a term has no lease when it goes on, and has heard nobody since: it makes no
// view without those that it did not hear again, for as long as it was away.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "overlay/cluster/messages.h"
#include "romano/base/flat_map.h"
#include "romano/base/time.h"

namespace romano::cluster {

class Lease {
public:
    Lease(const LogId& self, Duration beacon_every, Duration detection_timeout);

    // --- the own lease
    /// The next heartbeat has that tick. Called before the heartbeat is sent.
    void on_beat(Instant now, std::uint64_t tick);
    /// How long nothing was done, when that was a term or longer: others may have gone on
    /// meanwhile. Said once for each standstill; to be asked before an input is looked at.
    [[nodiscard]] std::optional<Duration> notice_standstill(Instant now);
    /// `by` heard that tick of ours, and says so in the view that it has installed. `vouched`: who
    /// echoed a tick of its own within a term, as it says.
    void on_echo(const LogId& by, std::uint64_t tick, const ViewNumber& installed,
                 const std::vector<BrokerId>& vouched);
    [[nodiscard]] bool is_held(Instant now) const;
    /// Until the view was installed.
    [[nodiscard]] bool was_held_before() const { return was_held_before_; }

    // --- the leases of others
    void on_heard(Instant now, const LogId& peer, std::uint64_t tick);
    /// What was heard of it so far may have waited since our last standstill began.
    [[nodiscard]] bool may_be_outdated(const LogId& peer) const;
    /// Long enough for whoever lives to be heard since our last standstill.
    [[nodiscard]] bool has_waited(Instant now) const { return now >= missed_until_; }
    /// For the next heartbeat.
    [[nodiscard]] std::vector<Echo> echoes() const;
    [[nodiscard]] std::vector<BrokerId> vouched(Instant now) const;
    /// Members that the view leaves out are echoed no more, as long as it is wanted.
    void want(const View* wanted);
    using HasEnded = std::function<bool(const LogId&)>;
    /// The leases of those that the view leaves out are over then. `has_ended`: that life is over
    /// for certain, and its lease with it.
    [[nodiscard]] Instant is_over_at(const View& next, const HasEnded& has_ended) const;

    // --- views
    void on_promise(const View& promised);
    void on_view(Instant now, const View& installed);
    /// Another life, in no view.
    void restart(const LogId& self);

private:
    struct Heard {
        std::uint64_t tick = 0;
        Instant at{};
        std::uint64_t late_tick = 0;  // sent late in our last standstill, or after it
    };
    struct Refusal {
        Instant heard_at{};  // the last tick that was echoed
        bool is_promised = false;
    };
    struct Echoed {
        Instant stamped_at = Instant::min();  // our tick
        std::vector<BrokerId> vouched{};
    };
    struct EchoedAhead {
        ViewNumber installed{};
        Instant stamped_at{};
        std::vector<BrokerId> vouched{};
    };

    static constexpr std::size_t promises_most = 16;  // beyond it there is no lease until a view
    static constexpr std::size_t heard_most = 4'000;

    [[nodiscard]] Instant ends_at() const;
    [[nodiscard]] Instant own_word_ends_at(const LogId& member) const;
    [[nodiscard]] Instant word_ends_at(const LogId& member) const;
    [[nodiscard]] Instant majority_ends_at(const std::vector<LogId>& members) const;
    [[nodiscard]] Instant stamped_at(const LogId& echoed_by) const;
    [[nodiscard]] Instant echoed_heard_at(const LogId& peer) const;
    [[nodiscard]] bool keeps_less_than_half(const View& next) const;
    void take(const LogId& by, Instant stamped_at, const std::vector<BrokerId>& vouched);

    LogId self_;
    Duration beacon_every_;
    Duration term_;
    Duration margin_;  // by which each of the holder's terms is shorter
    View view_;
    bool was_held_before_ = false;
    FlatMap<LogId, Instant> members_since_;
    std::vector<View> promised_;  // since the view was installed
    struct Beat {
        std::uint64_t tick = 0;
        Instant stamped_at{};
    };
    std::deque<Beat> beats_;             // the own ones that may still be echoed in time
    Instant acted_at_ = never;           // the last heartbeat, or the end of the last standstill
    FlatMap<LogId, Echoed> echoed_;      // by members: the newest own tick
    FlatMap<LogId, EchoedAhead> ahead_;  // by those who are in a later view than we are
    FlatMap<LogId, Heard> heard_;
    FlatMap<LogId, Refusal> refused_;              // members that are not echoed
    Instant missed_until_ = Instant::min();        // after a standstill
    mutable Instant held_until_ = Instant::min();  // as far as it was looked up
};

}  // namespace romano::cluster
