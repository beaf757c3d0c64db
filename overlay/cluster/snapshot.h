// All that is a broker's own, for a peer that cannot continue its log: sessions, publishes that
// somebody's cursor has not passed, cursors. And all retained messages that it knows: who wrote one
// may be dead, and nobody has noticed yet. In parts; the last one says so.
#pragma once

#include "broker/core/broker_core.h"
#include "overlay/cluster/adoption.h"
#include "overlay/cluster/envelope.h"
#include "overlay/cluster/own_log.h"

namespace romano::cluster {

void send_snapshot(const broker::BrokerCore& broker, const Logs& logs, BrokerId to, Outbox& out);

}  // namespace romano::cluster
