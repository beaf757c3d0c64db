#include "bench/failover/trial.h"

#include <chrono>

namespace romano::bench {

double ms_between(Instant from, Instant to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
}

void read_parts(const Cluster& cluster, std::size_t victim, Instant fault, Instant arrival,
                Trial& trial) {
    std::optional<Instant> detected;
    std::optional<std::size_t> heir;
    const std::string serving = "serving " + cluster.service_text(victim);
    for (std::size_t i = 0; i < cluster.size(); ++i) {
        if (i == victim) continue;
        const TraceLine* lost = cluster.trace(i).find("lost " + cluster.name(victim), fault);
        if (lost != nullptr && (!detected || *lost->at < *detected)) detected = lost->at;
        if (cluster.trace(i).find(serving, fault) != nullptr) heir = i;
    }
    if (!detected || !heir) return;
    trial.heir = cluster.name(*heir);
    trial.parts.detect = ms_between(fault, *detected);
    const TraceTail& trace = cluster.trace(*heir);
    const TraceLine* view = trace.find("view ", fault);
    const TraceLine* adopts = trace.find("adopts ", fault);
    const TraceLine* served = trace.find(serving, fault);
    if (view == nullptr || adopts == nullptr) return;
    trial.parts.agree = ms_between(*detected, *view->at);
    trial.parts.adopt = ms_between(*view->at, *adopts->at);
    trial.parts.address = ms_between(*adopts->at, *served->at);
    trial.parts.deliver = ms_between(*served->at, arrival);
}

}  // namespace romano::bench
