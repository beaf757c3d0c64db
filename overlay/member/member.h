// One broker of a cluster, composed of its cores and still without I/O: broker core, cluster core,
// ROMANO server.
//
// It holds back what clients may not see before peers hold the events behind it (Send::after),
// carries log batches between the broker core and the peers, and turns view changes into adopted
// sessions and addresses. The shell owns sockets, the transport and one timer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "broker/core/broker_core.h"
#include "broker/server/carried_server.h"
#include "broker/uplink/uplink_core.h"
#include "election/failure_detector.h"
#include "overlay/cluster/cluster_core.h"
#include "overlay/cluster/options.h"
#include "overlay/cluster/ownership/service_address.h"
#include "overlay/cluster/speaking/held_output.h"
#include "overlay/cluster/speaking/waiting_input.h"
#include "overlay/member/carried_uplink.h"
#include "overlay/member/member_facts.h"
#include "overlay/member/status_teller.h"
#include "overlay/transport.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"

namespace romano::overlay {

using cluster::AnnounceAddress;
using cluster::GiveUpAddress;
using cluster::Notice;
using cluster::TakeAddress;

/// To be carried out in this order: local, peers, clients.
struct MemberActions {
    broker::Actions clients;  // only Send and Multicast; all may go out at once
    std::vector<Outgoing> peers;
    std::vector<cluster::LocalAction> local;
    std::vector<uplink::UplinkAction> uplink;

    void clear() {
        uplink.clear();
        clients.clear();
        peers.clear();
        local.clear();
    }
};

struct MemberOptions {
    broker::BrokerOptions broker;  // log and writes_log are set by the member
    cluster::ClusterOptions cluster;
    std::string name;
    std::uint64_t incarnation = 0;  // higher at each start: the wall clock in nanoseconds
    std::vector<Endpoint> home_addresses;
    bool romano = true;  // carries the ROMANO server
    std::optional<uplink::UplinkOptions> uplink = {};
    Endpoint link = {};  // where the process takes links from peers; family none: it takes none
    std::array<std::uint8_t, 16> link_secret = {};  // for them alone
};

class Member {
public:
    Member(const MemberOptions& options, std::uint64_t seed);
    Member(const Member&) = delete;
    Member& operator=(const Member&) = delete;

    void on_datagram(Instant now, const Endpoint& via, const Endpoint& from, Bytes datagram,
                     MemberActions& out);
    void on_peer_message(Instant now, const Envelope& envelope, MemberActions& out);
    /// The answer to TakeAddress, and at the start for each home address: served, or held by
    /// somebody else.
    void on_address(Instant now, const Endpoint& address, bool served, MemberActions& out);
    /// The link to a peer's process came up or was lost. `process` has the peer's incarnation at
    /// its start.
    void on_link(Instant now, const broker::LogId& process, election::Link link,
                 MemberActions& out);
    /// The link to the MQTT broker, asked for by OpenLink, came up or was lost.
    void on_uplink_up(Instant now, bool resumed, MemberActions& out);
    void on_uplink_down() {
        if (uplink_) uplink_->on_down();
    }
    /// To what PublishUp brought it.
    void on_uplink_answer(Instant now, const broker::LogPosition& position, uplink::Answer answer,
                          MemberActions& out);
    /// `token` comes back in Acknowledge; 0: nobody waits for it.
    void on_uplink_message(Instant now, const uplink::FromRemote& message, std::uint64_t token,
                           MemberActions& out);
    /// Battery or load of this machine, from 0 to 100: of two brokers of one rank the higher leads.
    void on_condition(Instant now, std::uint32_t reading, MemberActions& out);
    /// Whether the shell could serve a peer's home address, should that peer die.
    void on_ability(const Endpoint& address, bool can_take) {
        cluster_.on_ability(address, can_take);
    }
    void on_tick(Instant now, MemberActions& out);
    [[nodiscard]] Instant next_wakeup() const;
    /// What is to be done at once is done for nobody in particular: it may give way to others.
    [[nodiscard]] bool may_rest() const {
        return !begins_from_ && waiting_.empty() && !held_.is_behind() && cluster_.may_rest();
    }

    /// To be called when `out.clients` is about to leave: without a lease it waits, for others may
    /// have gone on meanwhile.
    void before_sending(Instant now, MemberActions& out);

    /// Told to people in $SYS/brokers/<name>.
    void on_usage(const cluster::Usage& usage) { cluster_.on_usage(usage); }

    /// See broker::BrokerCore::set_permissions. Peers compare the digest with theirs.
    void set_rights(const broker::Permissions* permissions, const std::string& digest);

    /// See broker::BrokerCore::set_full; asked for again with each batch of datagrams.
    void set_full(bool full) { broker_.set_full(full); }

    /// An orderly stop: the last beacon; the peers take over at once. Nothing is done after it.
    void leave(Instant now, MemberActions& out);

    /// The own log as it is now: a member that was replaced while it stood still begins a new one.
    [[nodiscard]] const broker::LogId& log() const { return log_; }
    [[nodiscard]] const broker::BrokerCore& broker() const { return broker_; }
    [[nodiscard]] const cluster::View& view() const { return cluster_.view(); }
    [[nodiscard]] const cluster::ClusterCore& cluster() const { return cluster_; }
    [[nodiscard]] election::Leadership leadership() const { return cluster_.leadership(); }
    [[nodiscard]] MemberFacts facts() const;
    /// What is said to clients would leave now, if it may_speak_from() there.
    [[nodiscard]] bool may_speak(Instant now) const {
        return !has_left_ && cluster_.is_in_view() && speaking().may_speak(now);
    }
    /// Clients are served there: neither does anything wait that they say, nor what is said to
    /// them.
    [[nodiscard]] bool may_speak_from(const Endpoint& address) const {
        return speaking().is_open(address);
    }
    /// Its clients may be told again that the address is here: nobody else is likely to serve it.
    /// On the smaller side of a cut somebody does, and clients that are called there as it ends
    /// would be spoken to from both sides (I1, I7).
    [[nodiscard]] bool may_announce(const Endpoint& address) const {
        return !speaking().is_silent(address) && !cluster_.on_smaller_side_since();
    }
    void check_invariants() const;

private:
    [[nodiscard]] const cluster::Speaking& speaking() const { return cluster_.speaking(); }
    [[nodiscard]] broker::BrokerOptions broker_options() const;
    void acquaint_broker();
    [[nodiscard]] cluster::Effects effects(Instant now, MemberActions& out) {
        return {now, broker_, work_, out.peers, out.local, cluster_.times()};
    }

    template <typename Act>
    void on_input(Instant now, MemberActions& out, Act&& act);

    // --- while others may have gone on for us
    void notice_standstill(Instant now, MemberActions& out);
    [[nodiscard]] bool may_be_elsewhere(const broker::SessionHeader& client) const;
    void hold_output(MemberActions& out);
    /// Counts leases that were lost.
    void note_lease(Instant now);
    void restart(Instant now, MemberActions& out);

    // --- the broker core's actions
    void carry_out(Instant now, MemberActions& out);
    void catch_up(Instant now, MemberActions& out);
    void absorb(Instant now, MemberActions& out);
    void send(Instant now, const broker::Send& send, broker::Seq safe, MemberActions& out);
    void serve_waiting(Instant now, MemberActions& out);
    void release_output(Instant now, std::size_t most, MemberActions& out);

    // --- the uplink
    void tend_uplink(Instant now, MemberActions& out);
    void go_on_uplink(Instant now, MemberActions& out);

    MemberOptions options_;
    std::uint64_t seed_;
    broker::LogId log_;
    broker::BrokerCore broker_;
    const broker::Permissions* permissions_ = nullptr;
    broker::CarriedServer server_;
    std::optional<CarriedUplink> uplink_;
    /// Came without a lease; the next one comes when this one is acknowledged.
    std::optional<std::pair<uplink::FromRemote, std::uint64_t>> late_message_;
    cluster::ClusterCore cluster_;
    broker::Actions work_;
    cluster::HeldOutput held_;
    cluster::WaitingInput waiting_;

    bool has_left_ = false;
    std::uint64_t replacements_ = 0;
    bool speaks_ = false;  // with a lease, when it was asked last
    std::uint64_t leases_lost_ = 0;

    bool broker_waits_ = false;  // its timers, as of the last tick: the lease was lost
    std::optional<std::uint32_t> begins_from_;  // the session from which on exchanges wait for it
    Instant fresh_from_ = Instant::min();       // what is read before came in a standstill
    bool stood_still_ = false;                  // and has had no lease since

    StatusTeller status_;
};

}  // namespace romano::overlay
