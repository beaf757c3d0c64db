// A broker in a cluster: the member core on UDP sockets, the transport between brokers and one
// timer. Service addresses come and go as the member says.
//
// A home address that a peer serves is no error: the broker joins without it and gets it handed
// back. One that a stranger has is refused.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/system/error_code.hpp>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "broker/daemon/bad_senders.h"
#include "broker/daemon/heap_limit.h"
#include "broker/daemon/processor_load.h"
#include "broker/daemon/protection.h"
#include "broker/daemon/rights_in_force.h"
#include "broker/daemon/running_broker.h"
#include "broker/daemon/standstill.h"
#include "broker/net/core_timer.h"
#include "broker/net/moved_addresses.h"
#include "broker/net/udp_service.h"
#include "overlay/daemon/condition_file.h"
#include "overlay/daemon/uplink.h"
#include "overlay/dds/dds_transport.h"
#include "overlay/dds/domain.h"
#include "overlay/link/link_service.h"
#include "overlay/member/member.h"
#include "overlay/ros2/rules.h"

namespace romano::daemon {

/// romano-broker-uplink has one.
using MakeUplink = std::unique_ptr<Uplink> (*)(boost::asio::io_context&,
                                               const uplink::MqttSettings&, uplink::LinkEvents);

class ClusterBroker : public RunningBroker, private net::DatagramHandler {
public:
    /// Throws Refusal. Runs `io` for a moment when an address is held by somebody else.
    ClusterBroker(boost::asio::io_context& io, const Settings& settings, OnServing on_serving,
                  MakeUplink make_uplink = nullptr);
    void leave() override;
    void read_rights_again() override;
    void add_metrics(metrics::Page& page) const override;

private:
    void open_addresses();
    void warn_of_shared_addresses() const;
    void warn_of_missing_right() const;
    void open_transport();
    void open_links();
    void open_uplink(MakeUplink make_uplink);
    void open_ros2();
    [[nodiscard]] uplink::LinkEvents link_events();
    void wait_for_the_holders();
    void start_member();

    void on_datagram(const Endpoint& via, const Endpoint& from, Bytes octets) override;
    void on_message(const Endpoint& via, const Endpoint& from, Bytes message);
    void on_batch_end() override;
    void on_peer_message(const overlay::Envelope& envelope);
    void on_particulars(const cluster::Beacon& beacon);
    void on_peers_drained();
    void tell_of_usage();
    void on_later_life(std::uint64_t incarnation);
    void listen_for_namesake();
    void begin_again();
    void on_link(const broker::LogId& process, election::Link link);
    void on_core_wakeup();
    void on_home_of_peer(const Endpoint& address);
    void look_around();
    void obey_rights();

    void carry_out();  // and arms the timer
    void act();
    [[nodiscard]] Instant next_turn() const;
    void tell_packets();
    void seal();
    [[nodiscard]] bool may_serve(const Endpoint& address) const;
    [[nodiscard]] bool can_serve(const Endpoint& address) const;
    void warn_of_missing_keys(const cluster::Beacon& beacon);
    void carry_out_locally();
    void warn_of_not_serving(const Endpoint& address, const boost::system::error_code& error);
    void on_home_address_returned();
    void say_when_serving();

    boost::asio::io_context& io_;
    Settings settings_;
    OnServing on_serving_;
    std::unique_ptr<Protection> protection_;  // null without --keys
    RightsInForce rights_;
    cluster::ViewNumber told_in_;  // all peers of that view were told of all clients
    std::vector<ros2::Rule> ros2_rules_;
    overlay::MemberOptions options_;
    net::MovedAddresses moved_;
    net::TurnClock& turns_;
    net::UdpService udp_;  // its sockets are closed before their addresses go
    std::unique_ptr<dds::Domain> domain_;
    std::unique_ptr<dds::DdsTransport> transport_;
    std::unique_ptr<link::LinkService> links_;  // null when the detector does not look at links
    std::unique_ptr<Uplink> uplink_;            // null without --uplink and --ros2-domain
    std::unique_ptr<overlay::Member> member_;   // null until every address is accounted for
    overlay::MemberActions actions_;
    net::CoreTimer timer_;
    Instant rests_until_ = Instant::min();
    net::CoreTimer look_timer_;
    net::CoreTimer later_life_timer_;
    std::uint64_t later_life_ = 0;  // the incarnation of one that peers know
    bool hears_namesake_ = false;   // since the timer was armed
    std::optional<ConditionFile> condition_;
    ProcessorLoad processor_load_;
    std::set<Endpoint> homes_of_peers_;  // that we may have to serve
    std::set<Endpoint> not_served_;      // people were told
    BadSenders bad_senders_;
    HeapLimit heap_limit_;
    Standstill standstill_;

    struct Answer {
        Endpoint address;
        bool served;
    };
    std::vector<Answer> answers_;          // to TakeAddress, for the member
    std::vector<Endpoint> listen_;         // the settings', with the ports that were chosen
    std::vector<Endpoint> held_;           // those of listen_ that are not served here yet
    std::vector<Endpoint> held_by_peers_;  // those of held_ that no stranger has
};

}  // namespace romano::daemon
