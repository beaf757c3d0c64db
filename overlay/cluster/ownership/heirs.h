// Who inherits: the leader's choice for every service address that lost its broker.
//
// Deterministic, from the members' answers alone. An address that a member already serves stays
// with it, for what is left of its sessions; one whose own broker is there goes to that one; the
// others go to the least loaded. An heir always is one that holds the dead broker's log,
// but for its last events perhaps, and one whose machine can serve the address, if there is any:
// when an address's own broker has just come back, that is whoever serves the address beside it, or
// was told to.
#pragma once

#include <map>
#include <vector>

#include "overlay/cluster/agreement/membership.h"

namespace romano::cluster {

/// To whom the last view gave an address, and in which life: its beacons may not say so yet.
using Appointed = std::map<Endpoint, LogId>;

struct Answers {
    const View& view;
    const std::map<LogId, ViewHoldings>& holdings;  // of all members
    const std::vector<Endpoint>& serving;           // by the leader itself
    const std::vector<Endpoint>& home;              // of the leader itself
    const Appointed& appointed;
    const std::vector<LogPosition>& ended;  // as the leader was told (ended_logs.h)
    LogId leader;
    std::uint32_t leader_sessions = 0;
};

/// The agreed last event of every log that somebody holds and that has no member: the last one that
/// is held, but for what only those hold who were replaced meanwhile. It came to them while they
/// stood still, others had agreed on an earlier end, and clients said it again to the heir. When
/// only those are left, what the others agreed on counts.
[[nodiscard]] std::map<LogId, Seq> agreed_ends(const Answers& answers);
[[nodiscard]] std::vector<Assignment> assign(const Answers& answers,
                                             const std::map<LogId, Seq>& ends,
                                             const Membership& membership);
/// The tails that members lack, to be sent by one that holds them. Who holds nothing inherits
/// nothing, and asks for itself (fetching.h).
[[nodiscard]] std::vector<std::pair<BrokerId, Fetch>> missing_tails(
    const Answers& answers, const std::map<LogId, Seq>& ends);

}  // namespace romano::cluster
