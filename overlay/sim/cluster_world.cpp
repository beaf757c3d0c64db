#include "overlay/sim/cluster_world.h"

#include <algorithm>
#include <chrono>

#include "overlay/sim/seed.h"

namespace romano::sim {

using namespace std::chrono_literals;

namespace {

std::string name_of(std::size_t broker) {
    return "broker" + std::to_string(broker);
}

ClusterBrokerOptions broker_options(const ClusterWorldOptions& world, std::size_t index) {
    Random random(seed_of(world.seed, "broker options", index));
    ClusterBrokerOptions options;
    options.name = name_of(index);
    options.node = World::broker_node(index);
    options.home_addresses = {World::service_address(index)};
    options.cluster = world.cluster;
    options.machine = world.machine;
    for (std::size_t i = 0; i < world.brokers; ++i) options.cluster.voters.push_back(name_of(i));
    options.cluster.rank = world.cluster.rank + random.below(3);
    options.broker.t_retry = world.t_retry;
    options.broker.n_retry = 20;  // bad links must not make it drop a message
    options.broker.t_wait = world.t_wait;
    options.broker.limits.queued_per_session = 100'000;  // overload is another matter
    if (world.has_cells) options.broker.cell_group = World::cell_group();
    options.wall_clock_error =
        random.between(-world.wall_clock_error_max, world.wall_clock_error_max);
    return options;
}

}  // namespace

ClusterWorld::ClusterWorld(const ClusterWorldOptions& options)
    : World(options.seed),
      options_(options),
      peers_(events(), trace(), options.peers, seed_of(options.seed, "broker network")),
      sights_(options.brokers),
      invariants_(options.cluster.log_events_kept) {
    if (!options.topics_with_rights.empty()) {
        std::vector<std::string> names;
        for (const auto& client : SealedPackets::clients(options.robots)) {
            names.push_back(client.client_id);
        }
        rights_ = std::make_unique<DrawnRights>(options.seed, names, options.topics_with_rights);
    }
    Random abilities(seed_of(options.seed, "abilities"));
    for (std::size_t i = 0; i < options.brokers; ++i) {
        ClusterBrokerOptions broker_of = broker_options(options, i);
        if (options.is_protected) broker_of.sealed = &sealed_;
        if (options.speaks_dtls) broker_of.dtls = &dtls_;
        if (options.is_protected || options.speaks_dtls) {
            broker_of.clients = SealedPackets::clients(options.robots);
        }
        broker_of.rights = rights_.get();
        if (options.are_some_unable) broker_of.serves_others = abilities.below(2) == 0;
        brokers_.push_back(std::make_unique<ClusterBroker>(
            broker_of, events(), clients(), peers_, trace(), seed_of(options.seed, "broker", i)));
        ClusterBroker& broker = *brokers_.back();
        broker.set_observer([this, &broker] { observe(broker); });
    }
}

Duration ClusterWorld::in_scale(Duration duration) const {
    return duration * (options_.cluster.detection_timeout / 1ms) / 100;
}

void ClusterWorld::start_brokers() {
    Random random(seed_of(seed(), "start"));
    const Duration within = in_scale(100ms);
    for (const auto& broker : brokers_) {
        events().after(random.between(0ms, within), [&broker = *broker] { broker.start(); });
    }
    run_for(within);
}

void ClusterWorld::change_rights() {
    Random random(seed_of(seed(), "change of rights"));
    rights_->change();
    for (const auto& broker : brokers_) {
        events().after(random.between(0ms, in_scale(200ms)),
                       [&broker = *broker] { broker.hear_of_rights(); });
    }
}

void ClusterWorld::observe(ClusterBroker& broker) {
    if (options_.are_invariants_judged) judge_invariants(broker);
    if (options_.cluster.elector != "raft") return;
    const election::Leadership leadership = broker.member().leadership();
    if (!leadership.leader) return;
    const auto [known, is_new] = leader_of_term_.try_emplace(leadership.term, *leadership.leader);
    if (is_new || known->second == *leadership.leader) return;
    violations_.push_back(
        {Promise::one_leader,
         "two leaders in term " + std::to_string(leadership.term) + ", says " + broker.name()});
}

void ClusterWorld::judge_invariants(const ClusterBroker& acting) {
    if (clients_.size() != robot_count()) {
        clients_.clear();
        for (std::size_t i = 0; i < robot_count(); ++i) clients_.push_back(robot(i).name());
    }
    std::size_t index = 0;
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        if (brokers_[i].get() == &acting) {
            index = i;
            look_at(acting, now(), clients_, sights_[i]);
        } else {
            look_again(*brokers_[i], now(), sights_[i]);
        }
    }
    for (const Invariant broken : invariants_.judge(now(), sights_, index)) {
        const auto which = static_cast<std::size_t>(broken);
        trace().note(now(), invariant_names[which], invariants_.breaches()[which]);
    }
}

std::optional<std::size_t> ClusterWorld::leader() {
    std::optional<broker::BrokerId> leader;
    for (const auto& broker : brokers_) {
        if (!broker->is_running()) continue;
        const auto its = broker->member().view().number.leader;
        if (leader && *leader != its) return std::nullopt;
        leader = its;
    }
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        if (leader && brokers_[i]->id() == *leader) return i;
    }
    return std::nullopt;
}

std::optional<std::size_t> ClusterWorld::home_of(const std::string& client_id) {
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        const ClusterBroker& broker = *brokers_[i];
        if (!broker.is_running() || broker.is_leaving()) continue;
        if (broker.member().broker().image(client_id)) return i;
    }
    return std::nullopt;
}

void ClusterWorld::part(const std::vector<std::set<std::size_t>>& sides, bool clients_too) {
    const auto side_of = [&](std::size_t broker) {
        return std::ranges::find_if(sides, [&](const auto& side) { return side.contains(broker); });
    };
    for (std::size_t a = 0; a < brokers_.size(); ++a) {
        for (std::size_t b = 0; b < brokers_.size(); ++b) {
            if (side_of(a) != side_of(b)) cut(a, b);
        }
    }
    if (!clients_too) return;
    for (std::size_t r = 0; r < robot_count(); ++r) {
        for (std::size_t home = 0; home < brokers_.size(); ++home) {
            if (robot(r).options().broker != service_address(home)) continue;
            for (std::size_t b = 0; b < brokers_.size(); ++b) {
                if (side_of(b) == side_of(home)) continue;
                clients().cuts().cut_both(robot(r).options().node, broker_node(b), now());
            }
        }
    }
}

void ClusterWorld::deafen(std::size_t broker) {
    for (std::size_t other = 0; other < brokers_.size(); ++other) {
        if (other != broker) cut(other, broker);
    }
}

void ClusterWorld::heal() {
    peers_.join_all();
    clients().cuts().join_all();
}

std::vector<std::vector<ClusterBroker*>> ClusterWorld::components() {
    std::vector<std::vector<ClusterBroker*>> components;
    std::set<ClusterBroker*> placed;
    const auto hear_each_other = [this](const ClusterBroker& a, const ClusterBroker& b) {
        return !peers_.cuts().is_cut(a.node(), b.node()) &&
               !peers_.cuts().is_cut(b.node(), a.node());
    };
    for (const auto& first : brokers_) {
        if (!first->is_running() || !placed.insert(first.get()).second) continue;
        std::vector<ClusterBroker*> component{first.get()};
        for (std::size_t next = 0; next < component.size(); ++next) {
            for (const auto& other : brokers_) {
                if (!other->is_running() || !hear_each_other(*component[next], *other)) continue;
                if (placed.insert(other.get()).second) component.push_back(other.get());
            }
        }
        std::ranges::sort(component, {}, [](const ClusterBroker* b) { return b->node(); });
        components.push_back(std::move(component));
    }
    return components;
}

}  // namespace romano::sim
