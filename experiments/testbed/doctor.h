// The testbed's doctor: from what was seen of each machine, what is wrong with it, and what to do.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/testbed/host_facts.h"
#include "experiments/testbed/hosts_file.h"

namespace romano::experiments {

/// What was seen of one machine. What is empty was not reached.
struct HostSeen {
    std::string trouble;  // a finding of its own, which ended the look: a sentence
    std::optional<HostFacts> facts;
    std::optional<double> clock_offset_s;  // its clock minus ours
    double clock_uncertainty_s = 0;        // half of the way there and back
    std::string multicast_trouble;
    int longest_octets = 0;            // of its long multicast datagram
    std::map<std::string, int> heard;  // whose multicast, and how long
};

struct HostFinding {
    std::string host;  // empty: of all of them
    std::string about;
    bool is_problem = true;  // else a warning: experiments can run
    std::string sentence;
};

/// `seen` are those of testbed.hosts, in that order; `own_version` is this program's.
[[nodiscard]] std::vector<HostFinding> findings_of(const Testbed& testbed,
                                                   const std::vector<HostSeen>& seen,
                                                   const std::string& own_version);
[[nodiscard]] bool has_problem(const std::vector<HostFinding>& findings);

/// For people: a line each.
[[nodiscard]] std::string to_text(const std::vector<HostFinding>& findings);
[[nodiscard]] nlohmann::json to_json(const Testbed& testbed, const std::vector<HostSeen>& seen,
                                     const std::vector<HostFinding>& findings);

}  // namespace romano::experiments
