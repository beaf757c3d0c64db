// Who leads: the one interface of all election algorithms, as pure state machines.
//
// An elector is told which brokers are alive (a failure detector decides that), what they say in
// their beacons, and the time. It answers with a leader and a term, and with messages for its
// peers. Terms only grow; whoever sees two decisions follows the one with the higher (term, leader
// id).
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "romano/base/time.h"

namespace romano::election {

/// The same number as broker::BrokerId; election knows nothing of brokers.
enum class NodeId : std::uint64_t {};

using Term = std::uint64_t;

/// Orders candidates: configured capability, then battery or load, then id. Higher leads.
struct Rank {
    std::uint32_t capability = 0;
    std::uint32_t condition = 0;
    NodeId id{};

    friend bool operator==(const Rank&, const Rank&) = default;
    friend auto operator<=>(const Rank&, const Rank&) = default;
};

/// What a node says about leadership in each of its beacons.
struct Claim {
    Rank rank;
    Term term = 0;
    std::optional<NodeId> leader;  // whom it follows now

    friend bool operator==(const Claim&, const Claim&) = default;
};

/// A message of an algorithm that needs more than beacons (votes, bully's answers). `kind` and
/// `term` are the algorithm's own.
struct Ballot {
    std::uint8_t kind = 0;
    Term term = 0;
};
struct BallotTo {
    NodeId to;
    Ballot ballot;
};

struct Leadership {
    Term term = 0;
    std::optional<NodeId> leader;

    friend bool operator==(const Leadership&, const Leadership&) = default;
};

class Elector {
public:
    virtual ~Elector() = default;

    /// `node` was heard, with this claim.
    virtual void on_claim(Instant now, const Claim& claim) = 0;
    /// `node` is alive no more, in the detector's judgement, or has said goodbye.
    virtual void on_suspect(Instant now, NodeId node) = 0;
    virtual void on_ballot(Instant now, NodeId from, const Ballot& ballot) = 0;
    /// The own Rank::condition is another one now. Raft leads by votes, whatever the rank.
    virtual void on_condition(Instant now, std::uint32_t condition) = 0;
    /// The detector's time is this now: what begins from here on is waited for by it.
    virtual void on_detection_time(Duration detection_time) = 0;
    virtual void on_tick(Instant now) = 0;
    [[nodiscard]] virtual Instant next_wakeup() const = 0;

    [[nodiscard]] virtual Leadership leadership() const = 0;
    /// What the own beacon shall say.
    [[nodiscard]] virtual Claim claim() const = 0;
    /// Messages to send since the last call; cleared by it.
    [[nodiscard]] virtual std::vector<BallotTo> take_ballots() = 0;
};

struct ElectorOptions {
    Rank self{};
    Duration detection_time{};     // the detector's, at first; sets the scale of time-outs
    Duration listens_alone_for{};  // then who hears nobody leads; not in raft
    std::vector<NodeId> voters{};  // raft only
    std::uint64_t seed = 0;
};

/// By name (see elector_names()). Null for an unknown one.
[[nodiscard]] std::unique_ptr<Elector> make_elector(std::string_view name,
                                                    const ElectorOptions& options);
/// The names that make_elector knows, for messages and help.
[[nodiscard]] std::span<const std::string_view> elector_names();

}  // namespace romano::election
