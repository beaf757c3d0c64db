// The leader's or a member's ViewChange, and the peers that it knows by their beacons.
#pragma once

#include <gmock/gmock.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "overlay/cluster/agreement/view_change.h"
#include "tests/overlay/cluster/events.h"

namespace romano::cluster::view_change_test {

using namespace std::chrono_literals;

inline const LogId self = test::log_of("self");
inline const LogId peer = test::log_of("peer");
inline const LogId high = test::log_of("high");

// A leader and its peers, which it knows by their beacons.
struct Leader {
    static ClusterOptions of_rank(std::uint32_t rank) {
        ClusterOptions options;
        options.rank = rank;
        return options;
    }

    Membership membership{of_rank(5), self.broker, 1};
    Lease lease{self, 10ms, 100ms};
    ViewChange change{self};
    PeerLogs logs;
    ServiceAddresses addresses{{}};
    EndedLogs ended;
    Outbox out;
    std::optional<ViewAnnouncement> installed;  // last
    Instant now{1s};
    std::uint64_t ticks = 0;

    Surroundings around() {
        return {.membership = membership,
                .lease = lease,
                .logs = logs,
                .addresses = addresses,
                .ended = ended};
    }
    void hear(const LogId& from, const LogId& follows, election::Term term, std::uint32_t rank) {
        hear(from, follows, term, rank, change.view());
    }
    void hear(const LogId& from, const LogId& follows, election::Term term, std::uint32_t rank,
              View view, std::vector<BrokerId> hears = {self.broker}) {
        Beacon beacon{.log = from, .tick = ++ticks, .hears = std::move(hears)};
        beacon.promised = view.number;
        beacon.view = std::move(view);
        beacon.claim = {.rank = {.capability = rank, .id = node_of(from.broker)},
                        .term = term,
                        .leader = node_of(follows.broker)};
        membership.on_beacon(now, beacon);
        logs.try_emplace(from, from, 1'000);
    }
    /// Its beacons reach us, and ours do not reach it.
    void hear_of_no_us(const LogId& from) {
        membership.on_beacon(now, Beacon{.log = from, .tick = ++ticks});
    }
    void wait(Duration time) {
        for (const Instant end = now + time; now < end;) {
            now += 10ms;
            membership.on_tick(now);
            change.on_tick(now, around(), out);
            take_view();
        }
    }
    /// After each input, as the cluster core does.
    void take_view() {
        if (auto taken = change.take_installed()) installed = std::move(taken);
    }
    [[nodiscard]] election::Term term() { return membership.leadership().term; }
    template <typename Message>
    [[nodiscard]] std::size_t said_to(const LogId& member) const {
        return static_cast<std::size_t>(std::ranges::count_if(out, [&](const auto& outgoing) {
            return outgoing.to == member.broker &&
                   std::holds_alternative<Message>(outgoing.message);
        }));
    }
    [[nodiscard]] bool proposes() const {
        return std::ranges::any_of(out, [](const auto& outgoing) {
            return std::holds_alternative<ViewProposal>(outgoing.message);
        });
    }
    /// Every member answers what it was asked last.
    void answer(const LogId& member, ViewHoldings holdings = {}) {
        std::optional<ViewNumber> asked;
        for (const auto& outgoing : out) {
            const auto* proposal = std::get_if<ViewProposal>(&outgoing.message);
            if (proposal != nullptr && outgoing.to == member.broker) asked = proposal->view.number;
        }
        if (!asked) return;
        holdings.number = *asked;
        change.on_holdings(now, member, holdings, around(), out);
        take_view();
    }
    /// From this moment on.
    void lead() {
        while (!membership.leads()) wait(10ms);
    }
    /// In a view with the peer.
    void begin() {
        wait(200ms);
        for (int i = 0; i < 20 && !change.has_view(); ++i) {
            hear(peer, self, term(), 1);
            wait(10ms);
            answer(peer);
        }
        ASSERT_EQ(change.view().members.size(), 2U);
    }
};

}  // namespace romano::cluster::view_change_test
