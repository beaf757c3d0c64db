// Where the cluster's parts act: the broker core that they are brokers of, the buffers that take
// what is to be sent and done, and the time. Passed down with each input; nothing of it is kept.
#pragma once

#include <vector>

#include "broker/core/broker_core.h"
#include "overlay/cluster/envelope.h"
#include "overlay/cluster/ownership/service_address.h"
#include "overlay/cluster/times.h"
#include "romano/base/time.h"

namespace romano::cluster {

struct Effects {
    Instant now;
    broker::BrokerCore& broker;
    broker::Actions& clients;
    Outbox& peers;
    std::vector<LocalAction>& local;
    Times times;
};

}  // namespace romano::cluster
