#include "overlay/daemon/member_options.h"

#include "broker/daemon/broker_options.h"

namespace romano::daemon {
namespace {

// Two brokers that prove themselves to each other have done so after a third of a second, on a busy
// machine later.
constexpr auto proven_within = std::chrono::seconds{1};

cluster::ClusterOptions cluster_options(const ClusterSettings& settings) {
    cluster::ClusterOptions out;
    out.elector = settings.elector;
    out.voters = settings.voters;
    out.detector = settings.detector;
    out.rank = settings.rank;
    out.acks = settings.acks.value_or(cluster::all_peers);
    out.profile = settings.profile;
    out.version = ROMANO_VERSION;
    out.beacon_every = settings.beacon_every;
    out.detection_timeout = settings.detection_timeout;
    out.phi_threshold = settings.phi_threshold;
    if (settings.is_protected) out.found_within = proven_within;
    return out;
}

}  // namespace

overlay::MemberOptions member_options(const Settings& settings) {
    overlay::MemberOptions out;
    out.broker = broker_options(settings);
    out.cluster = cluster_options(*settings.cluster);
    out.romano = settings.romano;
    out.name = settings.name;
    out.incarnation = out.broker.log.incarnation;
    if (settings.uplink) out.uplink = settings.uplink->options;
    return out;
}

}  // namespace romano::daemon
