// The design's promises P1 to P8 as checks. P2, P3, P5 and P7 are judged from what clients saw
// alone; P1, P4 and P6, of a settled cluster, in settlement.h.
//
// Safety may be judged at any time. That everything has arrived (P2, P7) only after faults have
// ended and the robots are idle again.
#pragma once

#include <string>
#include <vector>

#include "overlay/sim/drawn_rights.h"
#include "overlay/sim/ledger.h"

namespace romano::sim {

enum class Promise : std::uint8_t {
    one_leader = 1,
    nothing_lost = 2,
    exactly_once = 3,
    one_home = 4,
    in_order = 5,
    same_state = 6,
    will_once = 7,
    bounded = 8,
    /// Not in the design's list: what must come back in bounded time when faults end.
    liveness = 9,
    /// Nor is this: no nonce twice under one key, and nothing taken that no robot said
    /// (romano/protection, broker/dtls).
    sealed_once = 10,
    /// Nor is this: nobody reads or says what its rights forbid, and what they allow is not
    /// refused.
    rights_kept = 11,
};

struct Violation {
    Promise promise;
    std::string what;
};
using Violations = std::vector<Violation>;

/// "P2 robot1 never got robot0's message 17 ...", a line each.
[[nodiscard]] std::string to_text(const Violations& violations);

/// From the first cut to the settled cluster after the heal.
struct Span {
    Instant from;
    Instant until;
};

struct Judgement {
    /// QoS 0 may be overtaken on links whose delay varies.
    bool links_keep_order = false;
    /// Brokers were parted and their clients were not: both sides spoke to a client, so that what
    /// it got then, or had not had an answer to, may come twice and out of order (overlay/cluster,
    /// known limits).
    std::vector<Span> parted{};
    const DrawnRights* rights = nullptr;  // where there are some
};

/// P3, P5, that no will was published without reason (P7), and rights: true at any time.
void judge_safety(const Ledger& ledger, const Judgement& judgement, Violations& out);
/// P2, the rest of P3 and P7, and that publishers got their answers: true once all is quiet.
void judge_completeness(const Ledger& ledger, const Judgement& judgement, Violations& out);

}  // namespace romano::sim
