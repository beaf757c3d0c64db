// What brokers say to each other, as plain values. A transport turns them into octets and back.
//
// Heartbeats and pulses are best-effort and go to everybody. Log batches and what is told of sealed
// packets are reliable and go to everybody, batches that fill a gap to one peer. The rest is
// addressed to one peer: reliable and in order, except QoS 0 forwards. Positions stand in
// everything that matters, so that a transport that loses silently is noticed.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "broker/core/log_event.h"
#include "broker/core/log_position.h"
#include "broker/core/session_image.h"
#include "election/elector.h"
#include "romano/base/endpoint.h"

namespace romano::cluster {

using broker::BrokerId;
using broker::LogId;
using broker::LogPosition;
using broker::Seq;

/// Number of a view; the higher one wins.
struct ViewNumber {
    election::Term term = 0;
    BrokerId leader{};
    std::uint64_t count = 0;  // views that this leader made in this term

    friend auto operator<=>(const ViewNumber&, const ViewNumber&) = default;
};

/// The agreed set of live brokers. Members are their logs: a restarted broker is another member.
struct View {
    ViewNumber number{};
    std::vector<LogId> members{};  // sorted

    [[nodiscard]] bool contains(const LogId& log) const;
    /// Another life of that log's broker, a later one, is a member.
    [[nodiscard]] bool has_later_life_of(const LogId& log) const;

    friend bool operator==(const View&, const View&) = default;
};

/// Where the sender's process takes links (election::Link). Family none: nowhere.
struct LinkAddress {
    Endpoint endpoint{};
    std::uint64_t process = 0;  // its incarnation at its start; its log may be of a later life
    std::array<std::uint8_t, 16> secret{};  // by which both ends of a link prove that they may

    friend bool operator==(const LinkAddress&, const LinkAddress&) = default;
};

/// The newest tick that the sender heard of a member of its view (speaking/lease.h).
struct Echo {
    LogId of{};
    std::uint64_t tick = 0;

    friend bool operator==(const Echo&, const Echo&) = default;
};

/// How far the log of a member is held; the member by its place in the view.
struct HeldByMember {
    std::uint32_t member = 0;
    Seq through = 0;

    friend bool operator==(const HeldByMember&, const HeldByMember&) = default;
};

/// What the sender's process does, for people.
struct Usage {
    std::uint64_t transport_octets_sent = 0;  // between brokers, since the start
    std::uint64_t transport_octets_received = 0;
    std::uint32_t longest_turn_us = 0;  // that its shell was busy at a stretch, of late
    std::uint32_t cpu_percent = 0;      // of a core, that its process had of late
};

/// All that a broker says of itself from time to time. It travels in two parts, for most of it
/// changes rarely: Heartbeat and Particulars (heartbeat.h).
struct Beacon {
    std::string name{};
    LogId log{};             // the sender's own
    Seq last_seq = 0;        // end of the sender's log
    std::uint64_t tick = 0;  // counts the sender's beacons
    View view{};
    ViewNumber promised{};  // the highest that the sender promised; not below its view's
    election::Claim claim{};
    /// Whose beacons reach the sender, sorted: a link counts both ways.
    std::vector<BrokerId> hears{};
    std::vector<Echo> echoes{};          // as read from a heartbeat: of the reader alone
    std::vector<BrokerId> vouched{};     // members that echoed a tick of the sender just now
    std::vector<LogPosition> applied{};  // how far the sender holds each peer's log; by log
    std::vector<LogPosition> ended{};    // removed logs, and where its view says that they end
    std::vector<Endpoint>
        home_addresses{};  // the service addresses that are the sender's by configuration
    std::vector<Endpoint> serving{};  // the service addresses that it answers on now
    std::vector<Endpoint> binding{};  // of these: it waits there for the sessions, and says nothing
    std::uint32_t sessions = 0;
    std::uint32_t connected = 0;
    std::uint32_t cannot_take = 0;  // so many of the peers' home addresses, were they to die
    Usage usage{};
    bool leaving = false;  // the last beacon of an orderly stop
    LinkAddress link{};
    std::uint32_t settings = 0;  // digest of what all brokers must agree on (settings_comparison.h)
    std::uint32_t predefined = 0;  // of the predefined topics; 0: there are none

    /// How far the sender holds the log: applied it, with what it tells of (acknowledgements.h).
    [[nodiscard]] std::optional<Seq> held_of(const LogId& other) const;
    [[nodiscard]] Seq applied_through(const LogId& of) const { return held_of(of).value_or(0); }
    /// And in this life: what is sent to it arrives.
    [[nodiscard]] bool hears_from(BrokerId broker) const;
    [[nodiscard]] std::optional<Seq> end_of(const LogId& of) const;
};

/// The part of a beacon that is said every beacon interval. With each member of the view it grows
/// by an octet and a bit.
struct Heartbeat {
    LogId log{};
    std::uint64_t tick = 0;
    Seq last_seq = 0;
    std::uint32_t particulars = 0;  // digest of the other part
    ViewNumber view{};
    ViewNumber promised{};
    election::Claim claim{};
    std::uint32_t members = 0;                  // so many are in it; 0: the sender is in no view
    std::vector<std::uint8_t> hears_members{};  // a bit each, in the order of that view's members
    /// Of each member 0, or 1 + its tick modulo 127; and 128 when it echoed a tick of the sender
    /// just now.
    std::vector<std::uint8_t> echoes{};
    std::vector<BrokerId> hears_others{};
    std::vector<HeldByMember> held{};        // how far the sender holds some of the members' logs
    std::vector<LogPosition> held_others{};  // and of other logs
    std::uint32_t logs_held = 0;             // of so many logs in all
    std::uint32_t sessions = 0;
    std::uint32_t connected = 0;
    Usage usage{};  // no octets sent: not said this time
    bool leaving = false;
};
/// A setting that all brokers must agree on, as people wrote it.
struct Setting {
    std::string name{};
    std::string value{};       // cut when it is long
    std::uint32_t digest = 0;  // of the whole value
};
/// The other part, to whoever asks because the digest is new to it, and to all peers when it
/// changes. `beacon` has what the heartbeat of that tick says, too, and in full.
struct Particulars {
    Beacon beacon{};
    std::vector<Setting> settings{};
    bool wanted = false;  // "tell me yours": the sender says nothing of itself
};

/// "My process lives, though its next beacon is late": a turn takes long, or others have the
/// processor. Tells nothing else, and not for long (overlay/pulses.h).
struct Pulse {
    LogId log{};
    std::uint64_t tick = 0;  // the last beacon's
};

/// Events first_seq, first_seq + 1, ... of a log: of the sender's to all, as they are written, or
/// to one who lacks them.
struct LogBatch {
    LogId log{};
    Seq first_seq = 0;
    std::vector<broker::LogEventPtr> events{};
    bool awaited = true;  // a client or a peer waits until enough members hold it
};
/// "I hold your log up to here." `by`: the sender's own log, so that an earlier life does not speak
/// for this one.
struct LogAck {
    LogPosition through{};
    LogId by{};
};
/// QoS 0 publishes for the receiver's subscribers; best-effort.
struct ForwardBatch {
    std::vector<broker::MessagePtr> messages{};
};
struct ElectionMessage {
    election::Ballot ballot;
};

// --- view change: overlay/cluster/agreement/view_change.h
// ---------------------------------------------------

/// The leader proposes; receivers freeze the logs of brokers that are members no more and answer.
struct ViewProposal {
    View view{};
    std::vector<LogId> removed{};
};
/// A service address of a removed broker, as the sender's mirror of its log tells.
struct LeftAddress {
    LogId log{};
    Endpoint address{};
};
/// The last event that the sender holds of each removed log.
struct ViewHoldings {
    ViewNumber number{};
    std::vector<LogPosition> holds{};
    std::vector<LogId> outdated{};  // of these: the sender was replaced when they were members' yet
    std::vector<LeftAddress> addresses{};   // the leader itself may be too new to know
    std::vector<LogPosition> kept_after{};  // what it can send of them: the events after these, or
                                            // where none is named, all
    std::vector<LogId> foreign{};           // of these: topic ids mean something else to the sender
    std::vector<Endpoint> cannot_take{};  // peers' home addresses that its machine would not serve
    std::vector<Endpoint> serving{};      // or about to: its beacon may not say so yet
};
/// What becomes of a removed broker's service address and of the sessions that use it.
struct Assignment {
    LogPosition end{};  // the removed log, and its agreed last event
    Endpoint
        address{};  // family none: the sessions without a service address of the removed broker
    BrokerId heir{};
};
struct ViewAnnouncement {
    View view{};
    std::vector<Assignment> assignments{};
    std::vector<LogPosition> ends{};  // agreed last event of each removed log
};

// --- joining and healing
// --------------------------------------------------------------------------

/// "Send what follows of that log": the next events (LogBatch), or where they are not kept, and to
/// who holds nothing of it (after 0), a snapshot. Said by who lacks it, or by a leader of what a
/// member lacks of a removed log.
struct Fetch {
    LogPosition after{};  // exclusive
    BrokerId to{};
};
/// A session between two homes: as its former one left it with the event `at`, and for whom.
struct MovedSession {
    broker::SessionImage image;
    LogId to;
    Seq at = 0;
};
/// A part of a snapshot: of the sender's own state, or of what a removed broker published. Parts
/// come in order. What a later part says of a session replaces what an earlier one said: with the
/// last part the whole is as of its `as_of`.
struct SnapshotPart {
    LogPosition as_of{};
    Seq since = 0;  // the log's end when the snapshot was begun: the same in all its parts
    std::uint32_t part = 0;
    bool last = false;
    std::vector<broker::SessionImage> sessions{};
    std::vector<broker::ClientId> gone{};  // sessions that were in earlier parts
    std::vector<broker::MessagePtr> retained{};
    std::vector<broker::MessagePtr> publishes{};  // of the log, not yet passed by all cursors
    std::vector<LogPosition> cursors{};           // the sender's own
    std::vector<MovedSession> moved{};            // of those that are gone: not yet elsewhere
};

// --- roaming
// -------------------------------------------------------------

/// "A client of yours talks to me now: move its session here" (broker::SessionMoved).
struct SessionRequest {
    broker::ClientId client_id{};
    Endpoint at{};  // the service address that it talks to
};

/// How far the packets of a protected client were taken (overlay/packets_told.h).
struct PacketsOfClient {
    std::uint64_t sender = 0;
    std::uint32_t run = 0;
    std::uint32_t floor = 0;

    friend bool operator==(const PacketsOfClient&, const PacketsOfClient&) = default;
};
/// A client's DTLS association (overlay/associations_told.h).
struct AssociationOfClient {
    std::uint64_t id = 0;
    std::string client{};
    Endpoint via{};
    Endpoint from{};
    std::vector<std::uint8_t> keys{};  // wrapped: broker/dtls/wrapped_keys.h
    std::uint32_t turn = 0;
    std::uint64_t floor = 0;
    struct Roaming {
        std::vector<std::uint8_t> id{};  // what the client is sent
        Endpoint at{};

        friend bool operator==(const Roaming&, const Roaming&) = default;
    };
    std::optional<Roaming> roaming{};  // of a client with a Connection ID

    friend bool operator==(const AssociationOfClient&, const AssociationOfClient&) = default;
};
struct ProgressOfAssociation {
    std::uint64_t id = 0;
    std::uint32_t turn = 0;
    std::uint64_t floor = 0;
    bool closed = false;

    friend bool operator==(const ProgressOfAssociation&, const ProgressOfAssociation&) = default;
};
/// What is known of clients that have keys, for who stands in for the sender. The cluster core
/// heeds it not.
struct SecuredTold {
    std::vector<PacketsOfClient> packets{};
    std::vector<AssociationOfClient> associations{};
    std::vector<ProgressOfAssociation> progress{};
};

using ClusterMessage = std::variant<Heartbeat, LogBatch, LogAck, ForwardBatch, ElectionMessage,
                                    ViewProposal, ViewHoldings, ViewAnnouncement, Fetch,
                                    SnapshotPart, SessionRequest, Pulse, Particulars, SecuredTold>;

/// How a message travels.
enum class Delivery : std::uint8_t {
    beacon,       // to all, best-effort, the newest counts: heartbeats and pulses
    log,          // to all, reliable, in order; what one is sent of it goes direct
    direct,       // to one, reliable, in order
    best_effort,  // to one, may be lost
};
[[nodiscard]] Delivery delivery_of(const ClusterMessage& message);

/// What a process may say for its core, which said this last and is late. None after the last
/// beacon of an orderly stop.
[[nodiscard]] std::optional<Pulse> pulse_after(const ClusterMessage& message);

}  // namespace romano::cluster
