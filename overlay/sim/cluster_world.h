// A world with a cluster of brokers, their network, and the faults that befall them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "overlay/sim/broker_network.h"
#include "overlay/sim/cluster_broker.h"
#include "overlay/sim/drawn_rights.h"
#include "overlay/sim/dtls_records.h"
#include "overlay/sim/invariants.h"
#include "overlay/sim/promises.h"
#include "overlay/sim/sealed_packets.h"
#include "overlay/sim/world.h"

namespace romano::sim {

struct ClusterWorldOptions {
    std::uint64_t seed = 1;
    std::size_t brokers = 3;
    cluster::ClusterOptions cluster;
    std::string profile{};  // its name, when the times are those of one
    BrokerNetworkOptions peers;
    Duration t_retry{std::chrono::milliseconds{500}};  // of the brokers
    Duration t_wait{std::chrono::seconds{1}};
    Duration wall_clock_error_max{std::chrono::milliseconds{20}};
    Machine machine;               // all of them
    bool are_some_unable = false;  // half of the machines take no addresses of peers
    bool has_cells = false;        // brokers send once for many that listen
    bool is_protected = false;     // robots and brokers seal their packets
    bool speaks_dtls = false;      // robots and brokers do
    std::size_t robots = 0;        // of a world with keys: so many at most
    std::vector<std::string_view> topics_with_rights{};  // of one with keys; none: all may do all
    bool are_invariants_judged = true;  // after every step: that is slow with many brokers
};

class ClusterWorld : public World {
public:
    explicit ClusterWorld(const ClusterWorldOptions& options);

    /// All brokers, one soon after the other.
    void start_brokers();

    [[nodiscard]] std::size_t broker_count() const { return brokers_.size(); }
    [[nodiscard]] ClusterBroker& broker(std::size_t index) { return *brokers_.at(index); }
    [[nodiscard]] BrokerNetwork& peers() { return peers_; }
    [[nodiscard]] SealedPackets& sealed() { return sealed_; }
    [[nodiscard]] DtlsRecords& dtls() { return dtls_; }
    /// Null where everybody may do everything.
    [[nodiscard]] const DrawnRights* rights() const { return rights_.get(); }
    /// Others are in force, on one broker after the other.
    void change_rights();
    [[nodiscard]] const ClusterWorldOptions& options() const { return options_; }
    /// What lasts so long where silence of 100 ms means death, here: faults, and what may be waited
    /// for after them.
    [[nodiscard]] Duration in_scale(Duration duration) const;
    /// No shorter than that: what does not end sooner because brokers are quick.
    [[nodiscard]] Duration in_scale_at_least(Duration duration) const {
        return std::max(in_scale(duration), duration);
    }
    [[nodiscard]] const std::string& elector() const { return options_.cluster.elector; }
    /// Index of the broker that the others follow; empty while they do not agree.
    [[nodiscard]] std::optional<std::size_t> leader();
    /// Index of the broker that is home to the client.
    [[nodiscard]] std::optional<std::size_t> home_of(const std::string& client_id);

    /// Brokers of different sides do not hear each other. With `clients_too`, a robot hears only
    /// the side that its broker is on (by its home address); without, all of them hear all brokers.
    void part(const std::vector<std::set<std::size_t>>& sides, bool clients_too);
    void cut(std::size_t from, std::size_t to) { peers_.cut(broker_node(from), broker_node(to)); }
    /// Nothing of what the others say comes to it; what it says goes to them.
    void deafen(std::size_t broker);
    /// All cuts end, of brokers and of robots.
    void heal();

    /// Running brokers that hear each other, by component, each sorted.
    [[nodiscard]] std::vector<std::vector<ClusterBroker*>> components();

    /// Violations that were seen while the run went on: more than one leader in a term of raft.
    [[nodiscard]] const Violations& violations() const { return violations_; }
    [[nodiscard]] const Breaches& breaches() const { return invariants_.breaches(); }
    /// After the last step of any broker.
    [[nodiscard]] const Sight& sight(std::size_t broker) const { return sights_.at(broker); }

private:
    void observe(ClusterBroker& broker);
    void judge_invariants(const ClusterBroker& acting);

    ClusterWorldOptions options_;
    BrokerNetwork peers_;
    SealedPackets sealed_;
    DtlsRecords dtls_;
    std::unique_ptr<DrawnRights> rights_;
    std::vector<std::unique_ptr<ClusterBroker>> brokers_;
    std::map<election::Term, election::NodeId> leader_of_term_;
    Violations violations_;
    std::vector<std::string> clients_;  // names of all robots
    std::vector<Sight> sights_;         // of the brokers
    Invariants invariants_;
};

}  // namespace romano::sim
