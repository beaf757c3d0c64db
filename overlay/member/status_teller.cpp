#include "overlay/member/status_teller.h"

#include <utility>
#include <vector>

#include "overlay/member/status_topic.h"

namespace romano::overlay {
namespace {

/// The newest beacons: this broker's own, which is the first, and its peers'.
std::vector<cluster::Beacon> newest_beacons(const cluster::ClusterCore& cluster,
                                            const broker::BrokerCore& broker) {
    std::vector<cluster::Beacon> out{cluster.beacon(broker)};
    for (const auto& [id, peer] : cluster.membership().peers()) {
        out.push_back(peer.beacon);
        if (!peer.alive) out.back().serving.clear();
    }
    return out;
}

/// What this broker serves, and behind it what its peers do.
std::vector<Endpoint> serving_in(const cluster::ClusterCore& cluster) {
    std::vector<Endpoint> out = cluster.addresses().claimed();
    for (const auto& [id, peer] : cluster.membership().peers()) {
        out.emplace_back();  // whose it is matters, too
        const auto& serving = peer.beacon.serving;
        if (peer.alive) out.insert(out.end(), serving.begin(), serving.end());
    }
    return out;
}

std::string rights_of(const cluster::ClusterCore& cluster, const broker::LogId& self,
                      const broker::LogId& log) {
    const auto& settings = cluster.settings();
    if (log.broker == self.broker) return settings.own_value("rights");
    if (!cluster.membership().is_alive(log)) return {};
    return settings.value_at(log.broker, "rights");
}

}  // namespace

void StatusTeller::on_tick(Instant now, const cluster::ClusterCore& cluster,
                           broker::BrokerCore& broker, broker::Actions& out) {
    // An heir takes its addresses some time after the view in which it is one.
    bool is_news = cluster.view().number != told_view_ || cluster.leadership() != told_leadership_;
    const std::uint64_t news = cluster.membership().news();
    std::vector<Endpoint> claimed = cluster.addresses().claimed();
    if (news != looked_at_ || claimed != claimed_) {
        looked_at_ = news;
        claimed_ = std::move(claimed);
        is_news |= serving_in(cluster) != told_serving_;
    }
    if (now < next_ && !is_news) return;
    told_serving_ = serving_in(cluster);
    next_ = now + cluster.times().status_told_every();
    told_view_ = cluster.view().number;
    told_leadership_ = cluster.leadership();
    tell(now, cluster, broker, out);
}

void StatusTeller::tell(Instant now, const cluster::ClusterCore& cluster,
                        broker::BrokerCore& broker, broker::Actions& out) {
    const auto beacons = newest_beacons(cluster, broker);
    const broker::LogId& self = beacons.front().log;
    const auto name_of = [&](broker::BrokerId id) {
        for (const auto& beacon : beacons) {
            if (beacon.log.broker == id) return beacon.name;
        }
        return std::string{};
    };
    std::vector<std::string> members;
    for (const broker::LogId& member : cluster.view().members) {
        members.push_back(name_of(member.broker));
    }
    const auto is_alive = [&](const broker::LogId& log) {
        return log.broker == self.broker || cluster.membership().is_alive(log);
    };
    const auto not_heard_by = [&](const cluster::Beacon& beacon) {
        std::vector<std::string> names;
        if (!is_alive(beacon.log)) return names;
        for (const broker::LogId& member : cluster.view().members) {
            const bool is_itself = member.broker == beacon.log.broker;
            if (is_itself || !is_alive(member) || beacon.hears_from(member.broker)) continue;
            names.push_back(name_of(member.broker));
        }
        return names;
    };
    for (const auto& beacon : beacons) {
        const broker::LogId& log = beacon.log;
        const std::string topic = status_topic(beacon.name);
        std::string text =
            to_json({.beacon = beacon,
                     .alive = is_alive(log),
                     .leads = told_leadership_.leader == cluster::node_of(log.broker),
                     .view = cluster.view(),
                     .member_names = members,
                     .leader_name = name_of(told_view_.leader),
                     .teller_name = beacons.front().name,
                     .rights = rights_of(cluster, self, log),
                     .does_not_hear = not_heard_by(beacon),
                     .differences = cluster.membership().is_alive(log)
                                        ? cluster.settings().differences_with(log.broker)
                                        : std::vector<cluster::Difference>{}});
        std::string& told = told_[topic];
        if (told == text) continue;
        told = std::move(text);
        broker.set_system_topic(now, topic, as_octets(told), out);
    }
}

}  // namespace romano::overlay
