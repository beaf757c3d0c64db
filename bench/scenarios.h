// The questions of romano_broker_bench: a load each, and what of it is looked at.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/load/load_plan.h"

namespace romano::bench {

struct Scenario {
    std::string name;
    experiments::LoadPlan plan;
    bool with_others = false;   // mosquitto, other brokers and clients with keys take part
    bool with_keys = false;     // of those, clients with keys alone
    bool is_for_cells = false;  // plain broker and cell take part, with a socket for each client
    /// The figure is the latency at the plan's rate; else the throughput.
    [[nodiscard]] bool is_about_latency() const { return plan.rate_per_s.has_value(); }
};

/// `measured` is the time of each run. `scale` makes the big ones smaller, for a quick look.
[[nodiscard]] std::vector<Scenario> scenarios(Duration measured, bool small);

}  // namespace romano::bench
