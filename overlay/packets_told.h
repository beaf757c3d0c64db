// How far each protected client's packets were taken, between brokers: whoever stands in for a dead
// one takes none of them twice, and can speak to its clients at once.
//
// What was taken since is told before anything that depends on it: events of the log, beacons,
// sessions that move. So a successor knows at least as much as any answer that a client has had;
// what it may not know is a packet without an answer, of the last beacon interval.
#pragma once

#include <vector>

#include "broker/protection/protected_clients.h"
#include "overlay/cluster/envelope.h"

namespace romano::overlay {

/// Puts it in front of what is to be sent.
void tell_packets(broker::ProtectedClients& clients, std::vector<cluster::Outgoing>& outgoing);

void on_packets_told(const cluster::SecuredTold& told, broker::ProtectedClients& clients);

}  // namespace romano::overlay
