// The DTLS associations of clients, between brokers: whoever stands in for a dead one speaks to its
// clients without a handshake, takes none of their records twice, and repeats no number.
//
// What is new is told before anything that depends on it: a handshake before its last flight, how
// far a client was heard before events of the log and beacons, that a broker begins to speak before
// its first record. Keys travel wrapped (broker/dtls/wrapped_keys.h).
#pragma once

#include <vector>

#include "broker/dtls/dtls_clients.h"
#include "overlay/cluster/envelope.h"

namespace romano::overlay {

/// Puts it in front of what is to be sent.
void tell_associations(dtls::DtlsClients& clients, std::vector<cluster::Outgoing>& outgoing);

void on_associations_told(const cluster::SecuredTold& told, dtls::DtlsClients& clients);

}  // namespace romano::overlay
