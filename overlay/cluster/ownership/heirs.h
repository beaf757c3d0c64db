// Who inherits: the leader's choice for every service address that lost its broker.
//
// Equal answers and beacons lead to one choice. An address that a member already serves stays with
// it, and what is left of its sessions goes there; an address whose own broker is there goes to
// that broker; the others go to the least loaded member. Every heir holds the dead broker's log,
// but for its last events perhaps, and its machine can serve the address, if one of them can. An
// address's own broker that has just come back does not hold the log: then the heir is the member
// that serves the address beside it, or was told to.
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

/// The agreed last event of each held log whose writer is no member: the last one that a member
/// holds who was not replaced meanwhile. To those who were, more may have come while they stood
/// still: others had agreed on an earlier end by then, and clients said it again to the heir. Where
/// all holders were replaced, the end counts on which the others agreed.
[[nodiscard]] std::map<LogId, Seq> agreed_ends(const Answers& answers);
[[nodiscard]] std::vector<Assignment> assign(const Answers& answers,
                                             const std::map<LogId, Seq>& ends,
                                             const Membership& membership);
/// The tails that members lack, to be sent by one that holds them. Who holds nothing inherits
/// nothing, and asks for itself (fetching.h).
[[nodiscard]] std::vector<std::pair<BrokerId, Fetch>> missing_tails(
    const Answers& answers, const std::map<LogId, Seq>& ends);

}  // namespace romano::cluster
