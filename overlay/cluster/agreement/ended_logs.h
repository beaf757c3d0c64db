// Where the logs of removed brokers ended: we keep one end for each broker, that of its newest life
// that ended, as our views and our peers told it. Beacons tell it on.
//
// A broker that stood still for long learns from it that others went on for it, and from which
// event; brokers that came later tell it, too. A broker that stood still when the others agreed may
// hold more of a log than that: it has no say in where the log ended (heirs.h).
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "overlay/cluster/messages.h"

namespace romano::cluster {

class EndedLogs {
public:
    /// We keep the ends of so many brokers; any other learns from views alone that it was replaced.
    static constexpr std::size_t most = 256;

    /// A view was installed with these ends. The logs of its members live on, or live again.
    void on_view(const View& view, const std::vector<LogPosition>& ends);
    /// A peer says that logs ended there. We are in `view`: the logs of its members live.
    void learn(const View& view, const std::vector<LogPosition>& ends);

    [[nodiscard]] bool contains(const LogId& log) const;
    [[nodiscard]] std::vector<LogPosition> list() const;

private:
    std::map<BrokerId, LogPosition> ends_;
};

}  // namespace romano::cluster
