// Sessions that were adopted here and whose address another broker serves: this machine could not
// take the address, or this broker was not the first heir. The server fetches clients that speak
// from here (roaming.h); those that only listen would hear nothing until their next keep-alive. So
// all sessions go to the server, some in each turn, as soon as it reads this log. The server speaks
// already: its copy of a session, if it has one, may be the later one.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include "overlay/cluster/agreement/membership.h"
#include "overlay/cluster/effects.h"
#include "overlay/cluster/ownership/departures.h"
#include "overlay/cluster/ownership/service_addresses.h"

namespace romano::cluster {

class Strays {
public:
    explicit Strays(std::size_t sessions_per_turn) : sessions_per_turn_(sessions_per_turn) {}

    /// `half_adopted`: of these addresses' sessions it is not known yet which copies stay.
    void carry_on(Effects& effects, const Logs& logs, const Membership& membership,
                  const View& view, ServiceAddresses& addresses, Departures& departures,
                  const std::set<Endpoint>& half_adopted);

private:
    /// True when none is left.
    bool move_some(Effects& effects, const Endpoint& address, const LogId& server, const Logs& logs,
                   Departures& departures);

    std::size_t sessions_per_turn_;
    std::map<Endpoint, std::vector<broker::ClientId>> waiting_;  // to be moved, the next one last
};

}  // namespace romano::cluster
