#include "broker/daemon/cluster_broker.h"
#include "broker/daemon/lone_broker.h"
#include "broker/daemon/running_broker.h"

namespace romano::daemon {

std::unique_ptr<RunningBroker> start_broker(boost::asio::io_context& io, const Settings& settings,
                                            OnServing on_serving) {
    if (settings.cluster) {
        return std::make_unique<ClusterBroker>(io, settings, std::move(on_serving));
    }
    return std::make_unique<LoneBroker>(io, settings, on_serving);
}

}  // namespace romano::daemon
