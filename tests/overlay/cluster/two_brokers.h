// Two brokers as one of them, "self", sees them: its own broker core, and what "peer" says.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "overlay/cluster/cluster_core.h"
#include "tests/overlay/cluster/beacons.h"
#include "tests/overlay/cluster/events.h"

namespace romano::cluster::two_brokers {

using namespace std::chrono_literals;

inline const LogId self = test::log_of("self");
inline const LogId peer = test::log_of("peer");
inline const Endpoint ours = test::address(1);
inline const Endpoint theirs = test::address(2);
inline std::string client(std::size_t number) {
    return "robot" + std::to_string(number);
}

inline broker::SessionImage image(std::size_t number, const Endpoint& via) {
    return std::get<broker::SessionPut>(test::session(client(number), via)).image;
}

/// A broker core and who lends it to the cluster's parts.
struct Owner {
    Instant now{10s};
    broker::BrokerCore broker{test::writer_of(self), 1};
    broker::Actions clients;
    Outbox peers;
    std::vector<LocalAction> local;

    [[nodiscard]] Effects effects() { return {now, broker, clients, peers, local, test::times}; }
    template <typename Kind>
    [[nodiscard]] std::vector<Kind> take_sent() {
        std::vector<Kind> sent;
        for (auto& outgoing : peers) {
            if (auto* message = std::get_if<Kind>(&outgoing.message)) {
                sent.push_back(std::move(*message));
            }
        }
        peers.clear();
        return sent;
    }
};

/// Broker "self", and what it knows of "peer".
struct Cluster : Owner {
    explicit Cluster(const ClusterOptions& options = {})
        : core{options, {.name = "self", .log = self, .home_addresses = {ours}}, 1} {}

    ClusterCore core;
    std::uint64_t ticks = 0;

    /// A PINGREQ from there.
    [[nodiscard]] bool waits_for_session(const Endpoint& via, const Endpoint& from) const {
        static constexpr std::uint8_t pingreq[] = {2, 0x16};
        return core.speaking().waits_for_session(broker, via, from, pingreq);
    }

    void keep_log() {
        for (broker::Action& action : clients.list()) {
            if (const auto* append = std::get_if<broker::Append>(&action)) {
                core.append(append->seq, append->event);
            }
        }
        clients.clear();
    }
    void take(ClusterMessage message) {
        Effects acting = effects();
        core.on_message(acting, {peer, std::move(message)});
        keep_log();
    }
    void take(const Beacon& beacon) {
        Effects acting = effects();
        cluster::hear(core, acting, beacon);
        keep_log();
    }
    void tick() {
        Effects acting = effects();
        core.on_tick(acting, {});
        keep_log();
    }
    void serve(const Endpoint& address) {
        Effects acting = effects();
        core.on_address(acting, address, true);
        keep_log();
    }
    /// Time goes on by a beacon's interval.
    void pass() {
        now += 10ms;
        tick();
    }
    /// The peer's beacon, which says that it serves `serving`.
    void hear(Seq last_seq = 0, std::vector<Endpoint> serving = {theirs}) {
        now += 10ms;
        take(Beacon{.name = "peer",
                    .log = peer,
                    .last_seq = last_seq,
                    .tick = ++ticks,
                    .hears = {self.broker},
                    .echoes = {{self, core.beacon(broker).tick}},
                    .home_addresses = {theirs},
                    .serving = std::move(serving)});
        tick();
    }
};

/// Both are in a view, and "self" leads.
struct InAView : Cluster {
    InAView() {
        while (!core.leadership().leader) hear();
        ViewAnnouncement announcement{
            .view = {.number = {100, self.broker, 1}, .members = {self, peer}}};
        std::ranges::sort(announcement.view.members);
        take(announcement);
        hear();
    }
};

}  // namespace romano::cluster::two_brokers
