#include "overlay/sim/settlement.h"

#include <algorithm>
#include <map>
#include <vector>

#include "broker/core/mirror.h"

namespace romano::sim {

namespace {

using Component = std::vector<ClusterBroker*>;

std::string names(const Component& component) {
    std::string text;
    for (const ClusterBroker* broker : component) {
        if (!text.empty()) text += ", ";
        text += broker->name();
    }
    return text;
}

election::Rank rank_of(const ClusterBroker& broker) {
    return {.capability = broker.options().cluster.rank,
            .id = election::NodeId{static_cast<std::uint64_t>(broker.id())}};
}

std::optional<std::string> disagreement(const Component& component, const std::string& elector) {
    std::vector<broker::LogId> members;
    for (const ClusterBroker* broker : component) members.push_back(broker->log());
    std::ranges::sort(members);
    const cluster::View& view = component.front()->member().view();
    for (const ClusterBroker* broker : component) {
        const cluster::View& its = broker->member().view();
        if (its.members != members) {
            return broker->name() + "'s view has " + std::to_string(its.members.size()) +
                   " members, not exactly " + names(component);
        }
        if (its.number != view.number) {
            return broker->name() + " and " + component.front()->name() +
                   " are in views of different numbers";
        }
    }
    const auto leader = std::ranges::find_if(
        component, [&](const ClusterBroker* broker) { return broker->id() == view.number.leader; });
    if (leader == component.end()) return "the leader is none of " + names(component);
    if (elector == "raft") return std::nullopt;
    const auto highest = std::ranges::max_element(
        component, {}, [](const ClusterBroker* broker) { return rank_of(*broker); });
    if (*leader != *highest) {
        return (*leader)->name() + " leads, but " + (*highest)->name() + " ranks higher";
    }
    return std::nullopt;
}

/// P4: each client id has one home; a client that is connected has one at all.
void judge_homes(ClusterWorld& world, const Component& component, Violations& out) {
    std::map<std::string, std::vector<const ClusterBroker*>> homes;
    for (const ClusterBroker* broker : component) {
        for (const auto& image : broker->member().broker().images()) {
            homes[image.header.client_id].push_back(broker);
        }
    }
    for (const auto& [client_id, at] : homes) {
        if (at.size() < 2) continue;
        out.push_back({Promise::one_home, client_id + " is at home with " + at[0]->name() +
                                              " and with " + at[1]->name()});
    }
    if (world.components().size() != 1) return;
    for (std::size_t i = 0; i < world.robot_count(); ++i) {
        const Robot& robot = world.robot(i);
        if (robot.is_connected() && !homes.contains(robot.name())) {
            out.push_back({Promise::one_home, robot.name() + " is at home nowhere"});
        }
    }
}

/// What must be the same in a mirror. When a client was last heard is not told with every datagram,
/// and how far a home has worked through the logs is told lazily.
std::string describe(const broker::SessionImage& image) {
    std::string text = image.header.client_id + ' ' + std::to_string(image.header.epoch) + ' ' +
                       to_text(image.header.address.endpoint) + ' ' +
                       std::to_string(static_cast<int>(image.header.state));
    for (const broker::Subscription& s : image.subscriptions) text += " subscribes " + s.filter;
    for (const broker::TopicBinding& topic : image.topics) {
        text += " topic " + topic.name + (topic.known_to_client ? " known" : "");
    }
    for (const broker::Delivery& delivery : image.deliveries) {
        text += " delivery " + std::to_string(delivery.position.seq) + " stage " +
                std::to_string(static_cast<int>(delivery.stage));
    }
    for (const mqttsn::MsgId id : image.unreleased) {
        text += " unreleased " + std::to_string(static_cast<unsigned>(id));
    }
    return text;
}

/// P6, sessions: what each broker holds of each other's.
void judge_mirrors(const Component& component, Violations& out) {
    for (const ClusterBroker* home : component) {
        const auto images = home->member().broker().images();
        for (const ClusterBroker* peer : component) {
            if (peer == home) continue;
            const auto& logs = peer->member().cluster().peer_logs();
            const auto held = logs.find(home->log());
            if (held == logs.end()) {
                out.push_back({Promise::same_state,
                               peer->name() + " has no copy of " + home->name() + "'s sessions"});
                continue;
            }
            std::string its;
            for (const auto& image : images) its += describe(image) + '\n';
            std::string copies;
            for (const auto& image : held->second.mirror().images())
                copies += describe(image) + '\n';
            if (its == copies) continue;
            out.push_back({Promise::same_state, home->name() + "'s sessions\n" + its + "are to " +
                                                    peer->name() + '\n' + copies});
        }
    }
}

/// P6, retained messages.
void judge_retained(const Component& component, Violations& out) {
    const auto retained = [](const ClusterBroker& broker) {
        std::map<std::string, broker::LogPosition> by_topic;
        for (const auto& message : broker.member().broker().retained()) {
            by_topic.emplace(message->topic, message->position);
        }
        return by_topic;
    };
    const auto reference = retained(*component.front());
    for (const ClusterBroker* broker : component) {
        if (retained(*broker) == reference) continue;
        out.push_back({Promise::same_state, broker->name() + " and " + component.front()->name() +
                                                " keep different retained messages"});
    }
}

}  // namespace

std::optional<std::string> disagreement(ClusterWorld& world) {
    for (const Component& component : world.components()) {
        if (auto reason = disagreement(component, world.elector())) return reason;
    }
    return std::nullopt;
}

void judge_settlement(ClusterWorld& world, Violations& out) {
    for (const Component& component : world.components()) {
        if (const auto reason = disagreement(component, world.elector())) {
            out.push_back({Promise::one_leader, *reason});
        }
        judge_homes(world, component, out);
        judge_mirrors(component, out);
        judge_retained(component, out);
    }
}

}  // namespace romano::sim
