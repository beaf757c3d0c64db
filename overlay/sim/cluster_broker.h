// A broker of a cluster: the shipped Member with the duties of its shell.
//
// At its start it binds its home addresses, unless somebody holds them; it takes and gives up
// addresses as it is told, and carries messages between the member and both networks.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "broker/protection/protected_clients.h"
#include "overlay/member/member.h"
#include "overlay/pulses.h"
#include "overlay/sim/broker_network.h"
#include "overlay/sim/broker_process.h"
#include "overlay/sim/drawn_rights.h"
#include "overlay/sim/dtls_ends.h"
#include "overlay/sim/sealed_packets.h"

namespace romano::sim {

struct ClusterBrokerOptions {
    std::string name;
    Node node{};
    std::vector<Endpoint> home_addresses;
    cluster::ClusterOptions cluster;
    broker::BrokerOptions broker;
    Duration wall_clock_error{0};
    Machine machine;
    bool serves_others = true;  // its machine takes addresses of peers
    Duration binding_takes_max{std::chrono::milliseconds{2}};
    SealedPackets* sealed = nullptr;                 // of a world whose robots are protected
    DtlsRecords* dtls = nullptr;                     // of one whose robots speak DTLS
    std::vector<broker::ProtectedClient> clients{};  // of either
    DrawnRights* rights = nullptr;                   // of one whose robots may not do everything
};

class ClusterBroker final : public BrokerProcess {
public:
    ClusterBroker(const ClusterBrokerOptions& options, EventQueue& events, ClientNetwork& clients,
                  BrokerNetwork& peers, Trace& trace, std::uint64_t seed);

    /// An orderly stop: says goodbye, lives on for a moment, and ends.
    void leave();
    [[nodiscard]] bool is_leaving() const { return leaving_; }
    /// Of the rights that are in force now, soon; a stopped one when it goes on.
    void hear_of_rights();

    /// While up.
    [[nodiscard]] const overlay::Member& member() const { return *member_; }
    [[nodiscard]] const broker::LogId& log() const { return member_->log(); }
    [[nodiscard]] broker::BrokerId id() const { return broker::broker_id_of(name()); }
    [[nodiscard]] const ClusterBrokerOptions& options() const { return options_; }
    /// The host's time that the member's steps took so far; network and bookkeeping excluded.
    [[nodiscard]] std::chrono::nanoseconds core_time() const { return core_time_; }
    /// The service addresses from which the last step of the member said something to clients.
    [[nodiscard]] const std::set<Endpoint>& said_from() const { return said_from_; }
    /// Called after every step of the member.
    void set_observer(std::function<void()> observer) { observer_ = std::move(observer); }

private:
    void create_core() override;
    void destroy_core() override;
    void take(const Datagram& datagram) override;
    void take(const cluster::Envelope& envelope) override;
    void take(const broker::LogId& process, election::Link link);
    void tick() override;
    [[nodiscard]] Instant next_wakeup() const override { return member_->next_wakeup(); }
    void on_stop() override { peers_.stall(node()); }
    void on_stop_core() override;
    void on_go_on() override;
    void pulse_later();
    template <typename Step>
    void let_member(Step&& step);
    void tell_of_traffic();
    void carry_out();
    void take_address(const Endpoint& address);
    [[nodiscard]] bool can_serve(const Endpoint& address) const;
    void create_protection();
    void take_up_rights();
    void keep_on_disk();
    void seal(broker::Actions& actions);
    void tell_and_seal(overlay::MemberActions& actions);
    void store_bound(protection::Reserve& reserve);
    /// The world knows no kinds of addresses.
    [[nodiscard]] Endpoint as_service(Endpoint address) const;
    void answer_address(const Endpoint& address, bool served);

    ClusterBrokerOptions options_;
    std::uint64_t seed_;
    ClientNetwork& clients_;
    BrokerNetwork& peers_;
    /// What it finds again after a crash.
    struct Disk {
        std::uint32_t bound = 0;
        std::map<protection::SenderId, protection::Heard> heard;
    };
    Disk disk_;
    std::unique_ptr<broker::ProtectedClients> protection_;  // null in a plain world
    std::optional<DtlsBrokerEnd> dtls_;
    cluster::ViewNumber told_in_;  // all peers of that view were told of all clients
    std::unique_ptr<overlay::Member> member_;
    std::unique_ptr<overlay::Transport> transport_;
    overlay::MemberActions actions_;
    std::set<Endpoint> wanted_;  // the service addresses that the member has taken
    overlay::Pulses pulses_;
    cluster::Pulse pulse_;
    bool is_pulsing_ = false;
    bool leaving_ = false;
    std::uint64_t sent_before_ = 0;  // by earlier lives, in octets
    std::uint64_t received_before_ = 0;
    std::chrono::nanoseconds core_time_{0};
    std::set<Endpoint> said_from_;
    std::function<void()> observer_;
};

}  // namespace romano::sim
