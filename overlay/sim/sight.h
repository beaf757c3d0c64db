// What can be seen of one broker from outside at one moment: by this the invariants of the cluster
// are judged, so that a test can show a state that no broker is in.
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "broker/core/log_event.h"
#include "broker/core/log_position.h"
#include "broker/core/session_image.h"
#include "overlay/cluster/messages.h"
#include "overlay/cluster/times.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"

namespace romano::sim {

class ClusterBroker;

/// What a broker has of another one's log.
struct LogCopy {
    broker::LogId log{};
    broker::Seq applied = 0;
    broker::Seq acknowledged = 0;
    /// Where a view said that the log ends, and the first view that said so.
    struct End {
        broker::Seq seq = 0;
        cluster::ViewNumber in{};
    };
    std::optional<End> end{};
};

/// An event that was just acknowledged, and the event that it speaks of.
struct Reference {
    broker::LogId by{};
    broker::LogPosition to{};
    bool is_held = false;  // the message: applied in its own log, or no copy of a session lacks it
};

/// Of a client's session, as the log of that member says, another copy that outranks the own one.
struct HigherCopy {
    std::string client{};
    broker::LogId at{};

    friend bool operator==(const HigherCopy&, const HigherCopy&) = default;
};

/// A session between two homes, as its former home or a mirror of that one's log has it.
struct SessionBetween {
    broker::LogPosition moved{};  // by this event
    broker::SessionImage image{};
};

struct Sight {
    std::string name{};
    bool is_speaking = false;  // at this moment; all that follows is of its last step
    broker::LogId log{};
    cluster::View view{};
    cluster::ViewNumber promised{};
    cluster::Times times{};
    std::vector<broker::LogId> hears{};  // members, though they may not hear it
    broker::Seq shown = 0;               // of its own log, to clients
    std::size_t holders = 0;             // peers that must hold what it shows
    std::size_t own_events = 0;          // that it keeps
    broker::Seq own_last = 0;
    std::vector<broker::Sealed> sealed{};  // in its log, in this step
    std::vector<Endpoint> speaks_from{};
    std::set<Endpoint> said_from{};          // something, in this step
    std::vector<std::string> speaks_to{};    // clients
    std::vector<HigherCopy> higher{};        // of these, at members that it hears
    std::vector<LogCopy> copies{};           // sorted
    std::vector<Reference> references{};     // of this step
    std::vector<SessionBetween> leaving{};   // its own
    std::vector<SessionBetween> mirrored{};  // of others
    std::vector<std::string> twice{};  // clients of whom it has a session, and one that leaves

    [[nodiscard]] const LogCopy* copy_of(const broker::LogId& wanted) const;
};

/// After a step of the broker. `clients` are those that it may be home to.
void look_at(const ClusterBroker& broker, Instant now, const std::vector<std::string>& clients,
             Sight& sight);
/// Between its steps: a process that was stopped or stands still says nothing.
void look_again(const ClusterBroker& broker, Instant now, Sight& sight);

}  // namespace romano::sim
