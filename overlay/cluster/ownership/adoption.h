// This broker becomes the home of a session that another one had. It takes the image that the home
// or a mirror has, and the publishes between what that home had worked through and what we have.
#pragma once

#include <optional>
#include <vector>

#include "overlay/cluster/effects.h"
#include "overlay/cluster/replication/own_log.h"
#include "overlay/cluster/replication/peer_log.h"

namespace romano::cluster {

/// All logs that are held: the peers' and the own one.
struct Logs {
    PeerLogs& peers;
    OwnLog& own;

    /// Null when that log is not held.
    [[nodiscard]] const LogHistory* history_of(const LogId& log) const;
    /// Null when it is not kept.
    [[nodiscard]] MessagePtr publish_at(const LogPosition& position) const;
};

/// Publishes that we have worked through and the image's home had not: of each log in its order,
/// the logs merged by time.
[[nodiscard]] std::vector<MessagePtr> missed_publishes(const broker::SessionImage& image,
                                                       const broker::BrokerCore& broker,
                                                       const Logs& logs);

/// The image of a dead home's session, for another home than us, with what it missed and we have.
[[nodiscard]] broker::SessionImage caught_up(const Effects& effects, const Logs& logs,
                                             broker::SessionImage image);

/// `moved`: what its living home said of it. `ours`: the own copy that was on its way to another
/// home (departures.h).
void adopt(Effects& effects, const Logs& logs, broker::SessionImage image,
           const std::optional<LogPosition>& moved = std::nullopt,
           std::optional<broker::SessionImage> ours = std::nullopt);

}  // namespace romano::cluster
