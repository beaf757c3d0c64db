// How long the cluster waits for what: every wait between brokers, but the lease's
// (speaking/lease.cpp), is a named multiple of one of five times, and stands in this table.
//
// The detection time is the detector's own, as of now: phi-accrual changes it. The times in which a
// peer is found, and found again, belong to the transport (DDS) and the machines, and not to the
// beacons. People read at one pace on all networks.
#pragma once

#include <algorithm>

#include "romano/base/time.h"

namespace romano::cluster {

struct Times {
    Duration beacon_every{};
    Duration detection{};
    Duration found_within{};
    Duration found_again_within{};
    Duration people_told_every{};

    // --- beacons
    [[nodiscard]] Duration particulars_asked_again_after() const { return 2 * beacon_every; }

    // --- logs
    /// A gap may close by itself: what is late comes within two beacons. Who is asked answers at
    /// once; then the next one is asked. On a network that is full each answer makes it worse, so
    /// the more often it was asked for, the longer it is waited for.
    [[nodiscard]] Duration fetched_again_after(int times_asked) const {
        return std::min(2 * beacon_every * std::max(times_asked, 1), detection);
    }
    [[nodiscard]] Duration tail_waited_for() const { return 4 * detection; }
    [[nodiscard]] Duration message_waited_for() const { return 4 * detection; }
    [[nodiscard]] Duration cursors_told_every() const { return 5 * beacon_every; }
    [[nodiscard]] Duration logs_trimmed_every() const { return 10 * beacon_every; }
    /// Publishes that all have worked through: sessions on their way still ask for them.
    [[nodiscard]] Duration passed_publishes_kept_for() const { return 20 * detection; }
    /// A broker that was cut off for no longer goes on where its log was frozen.
    [[nodiscard]] Duration removed_log_kept_for() const { return 600 * detection; }
    /// Pieces of a snapshot: the heartbeats between them are not late.
    [[nodiscard]] Duration snapshot_pieces_every() const { return beacon_every / 5; }

    // --- order of what two homes of one client published
    [[nodiscard]] Duration former_home_waited_for() const { return 4 * detection; }
    [[nodiscard]] Duration snapshot_order_kept_for() const { return detection; }

    // --- views
    [[nodiscard]] Duration proposal_asked_every() const { return beacon_every; }
    [[nodiscard]] Duration proposal_kept_for() const { return 2 * beacon_every; }
    /// A leader waits for the answer of a member that follows somebody else, and a member for a
    /// leader to hear again whom it hears itself.
    [[nodiscard]] Duration disagreement_lasts() const { return 2 * detection; }
    [[nodiscard]] Duration announcement_arrives_within() const { return 2 * detection; }
    /// A newcomer listens for a detection time before it leads, unless it hears nobody: who is
    /// there says something in one of three beacons.
    [[nodiscard]] Duration lone_newcomer_leads_after() const {
        return std::min(3 * beacon_every, detection);
    }
    /// And then, before it opens a view. Alone is who never heard of anybody.
    [[nodiscard]] Duration newcomer_listens_for(bool is_alone) const {
        const Duration listens = found_within + 2 * detection;
        return is_alone ? std::min(listens, found_within + 2 * found_again_within) : listens;
    }
    /// On a busy machine it takes some detection times until two processes hear each other.
    [[nodiscard]] Duration unmet_peer_waited_for() const { return found_within + 20 * detection; }
    /// Its process may stand still, and is found again after that; then it needs some beacons.
    [[nodiscard]] Duration silent_home_waited_for() const {
        return 6 * found_again_within + 2 * detection;
    }
    [[nodiscard]] Duration members_read_within() const { return 20 * detection; }

    // --- addresses and sessions that move
    /// They wait for tails, and then pass on what they have.
    [[nodiscard]] Duration other_heirs_waited_for() const { return tail_waited_for() + detection; }
    [[nodiscard]] Duration addresses_sought_every() const { return 20 * beacon_every; }
    /// Answers may leave from an address that its owner has bound as well.
    [[nodiscard]] Duration answers_leave_within() const { return beacon_every / 5; }
    [[nodiscard]] Duration answers_leave_at_most_within() const { return detection; }
    [[nodiscard]] Duration binding_tried_every() const { return 3 * detection; }
    [[nodiscard]] Duration handover_acknowledged_within() const { return 10 * detection; }
    /// Twice as long as their homes wait before they take them back.
    [[nodiscard]] Duration moved_sessions_kept_for() const {
        return 2 * handover_acknowledged_within();
    }
    [[nodiscard]] Duration rival_hands_over_within() const { return 20 * detection; }
    [[nodiscard]] Duration rival_joins_within() const { return 40 * detection; }
    [[nodiscard]] Duration giver_met_within() const { return detection; }
    [[nodiscard]] Duration giver_waited_for() const { return 20 * detection; }
    [[nodiscard]] Duration dead_giver_removed_within() const { return 40 * detection; }
    [[nodiscard]] Duration conflicts_looked_at_every() const { return beacon_every; }
    [[nodiscard]] Duration session_asked_again_after() const { return detection / 2; }
    [[nodiscard]] Duration session_waited_for() const { return 2 * detection; }
    /// A home that lives answers, be it late; and takes back what does not arrive.
    [[nodiscard]] Duration living_home_waited_for() const { return handover_acknowledged_within(); }

    // --- silence that is not death
    [[nodiscard]] Duration clearly_heard_for() const { return detection / 2; }
    [[nodiscard]] Duration waiting_handover_outlives() const { return 8 * detection; }

    // --- the uplink's session
    /// By then a session that a robot or another leader left is at a home, or on its way to one.
    [[nodiscard]] Duration uplink_session_found_within() const {
        return handover_acknowledged_within();
    }
    [[nodiscard]] Duration uplink_session_asked_again_after() const { return session_waited_for(); }
    [[nodiscard]] Duration taken_safe_within() const { return 20 * detection; }

    // --- what people are told
    [[nodiscard]] Duration leaderless_told_every() const { return 100 * detection; }
    [[nodiscard]] Duration namesake_told_every() const { return 20 * people_told_every; }
    [[nodiscard]] Duration long_message_told_every() const { return 10 * people_told_every; }
    [[nodiscard]] Duration status_told_every() const { return people_told_every; }
};

}  // namespace romano::cluster
