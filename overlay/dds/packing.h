// Makes few samples of many messages: what one batch of client datagrams gave the peers to hear.
//
// A sample costs a system call and a wake-up at each reader; several events in one cost little more
// than one. Order within a topic stays; acknowledgements count up, so that the last one says all.
#pragma once

#include <vector>

#include "overlay/transport.h"

namespace romano::dds {

/// Joins, in place: consecutive log batches, QoS 0 forwards to one peer, acknowledgements of one
/// log to one peer.
void pack(std::vector<overlay::Outgoing>& messages);

}  // namespace romano::dds
