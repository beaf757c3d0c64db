// When nobody leads us for long, no view comes, and clients may wait. What people configured may be
// the cause, so that they are told whom we hear and what the elector waits for.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "overlay/cluster/options.h"
#include "overlay/cluster/ownership/service_address.h"
#include "romano/base/time.h"

namespace romano::cluster {

class Leaderless {
public:
    /// True when there was no leader or no view for so long, and people were not told meanwhile.
    bool is_to_be_told(Instant now, Duration told_every, bool is_led) {
        if (is_led || !since_) since_ = now;
        if (is_led || now - *since_ < told_every) return false;
        since_ = now;
        return true;
    }

private:
    std::optional<Instant> since_;  // led last, or told last
};

[[nodiscard]] inline Notice leaderless_notice(Duration since, const std::vector<std::string>& heard,
                                              const ClusterOptions& options) {
    const auto listed = [](const std::vector<std::string>& names) {
        std::string list;
        for (const auto& name : names) list += (list.empty() ? "" : ", ") + name;
        return list;
    };
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(since).count();
    std::string text =
        "no leader for " + std::to_string(seconds) + " s, clients may have to wait; ";
    text += heard.empty() ? "no peer is heard" : "heard: " + listed(heard);
    if (options.elector == "raft") {
        text += "; raft needs " + std::to_string(options.voters.size() / 2 + 1) +
                " of the voters " + listed(options.voters);
    }
    return {.text = std::move(text), .is_warning = true};
}

}  // namespace romano::cluster
