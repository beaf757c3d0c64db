#include "broker/daemon/broker_options.h"

#include <algorithm>
#include <random>

#include "broker/net/clock.h"
#include "broker/rights/rules.h"
#include "broker/server/carried_server.h"

namespace romano::daemon {

broker::BrokerOptions broker_options(const Settings& settings) {
    broker::BrokerOptions out;
    out.log.broker = broker::broker_id_of(settings.name);
    out.log.incarnation =
        std::max(static_cast<std::uint64_t>(net::unix_time().count()), settings.least_incarnation);
    out.unix_time_at_zero = net::unix_time_at_zero();
    out.gateway_id = settings.gateway_id;
    out.advertise_every = settings.advertise_period;
    if (settings.cell_group) out.cell_group = *settings.cell_group;
    out.t_retry = settings.t_retry;
    out.n_retry = settings.n_retry;
    out.predefined_topics = settings.predefined_topics;
    if (settings.romano) {
        out.observed_topics = broker::CarriedServer::observed_topics();
        out.never_retained = broker::CarriedServer::is_never_retained;
    }
    out.open_topic = rights::rights_topic;
    out.limits = settings.limits;
    return out;
}

std::uint64_t random_seed() {
    std::random_device device;
    return (std::uint64_t{device()} << 32U) | device();
}

}  // namespace romano::daemon
