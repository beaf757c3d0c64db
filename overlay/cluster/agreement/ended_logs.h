// Where the logs of removed brokers ended: of each broker the newest life that did, as the views
// told that we were in and as our peers know. Beacons tell it on.
//
// A broker that stood still for long learns from it that others went on for it, and from how far;
// also from those who came when its sessions had long been taken over. And who holds more of a log
// than that, because it stood still when the others agreed, has no say in where it ended (heirs.h).
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "overlay/cluster/messages.h"

namespace romano::cluster {

class EndedLogs {
public:
    /// Of so many brokers. Whoever comes after them learns by the views alone that it was replaced.
    static constexpr std::size_t most = 256;

    /// Whatever log is a member's lives on, or again.
    void on_view(const View& view, const std::vector<LogPosition>& ends);
    /// What somebody else knows.
    void learn(const View& view, const std::vector<LogPosition>& ends);

    [[nodiscard]] bool contains(const LogId& log) const;
    [[nodiscard]] std::vector<LogPosition> list() const;

private:
    std::map<BrokerId, LogPosition> ends_;
};

}  // namespace romano::cluster
