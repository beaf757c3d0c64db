#include "overlay/daemon/cluster_broker.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>

#include "broker/daemon/broker_options.h"
#include "broker/daemon/refusal.h"
#include "broker/daemon/service_addresses.h"
#include "broker/metrics/broker_metrics.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "broker/net/interface_address.h"
#include "broker/net/socket_address.h"
#include "overlay/associations_told.h"
#include "overlay/daemon/cluster_metrics.h"
#include "overlay/daemon/low_descriptors.h"
#include "overlay/daemon/member_options.h"
#include "overlay/daemon/peer_papers.h"
#include "overlay/daemon/ros2_bridge.h"
#include "overlay/dds/packing.h"
#include "overlay/packets_told.h"

namespace romano::daemon {
namespace {

using namespace std::chrono_literals;

// How long a newcomer listens for the peer that holds its address: discovery takes a fraction of a
// second, on a busy machine a few.
constexpr auto patience = 5s;

// A batch of publishes that each fan out to thousands must not pile up in memory.
constexpr std::size_t most_actions_held = 4096;
constexpr std::size_t most_octets_held = std::size_t{1} << 20U;

// A member that was replaced goes on under the next incarnation: fewer times than that.
constexpr std::uint64_t most_lives_of_a_process = 1'000'000;

constexpr auto look_every = 1s;
constexpr int rest_per_turn = 2;
constexpr std::size_t most_homes_of_peers = 1'000;

constexpr const char* missing_right =
    "addresses of brokers on other machines cannot be taken over here, the right CAP_NET_ADMIN is "
    "missing; as a service switch address-takeover.conf on (it says how, in "
    "/usr/share/doc/romano-broker/examples), else start as root";

constexpr const char* not_allowed =
    "this one was not given what it takes: --allow-plain for plain addresses that other machines "
    "reach, --keys for protected ones, a place in its --keys (`romano keys new`) for DTLS";

bool contains(const std::vector<Endpoint>& list, const Endpoint& address) {
    return std::ranges::find(list, address) != list.end();
}

/// Empty for the profiles that listen for less than a second.
std::string listening(const cluster::ClusterOptions& options) {
    const cluster::Times times = options.times(options.detection_timeout);
    const bool is_voted =
        options.elector == "raft";  // a term's first election is a random time away
    const Duration leads_after =
        is_voted ? 2 * options.detection_timeout : times.lone_newcomer_leads_after();
    const auto most =
        std::chrono::ceil<std::chrono::seconds>(leads_after + times.newcomer_listens_for(true));
    if (most <= 1s) return {};
    return ", listens for other brokers first: " + std::to_string(most.count()) +
           " s when there are none";
}

}  // namespace

ClusterBroker::ClusterBroker(boost::asio::io_context& io, const Settings& settings,
                             OnServing on_serving, MakeUplink make_uplink)
    : io_(io),
      settings_(settings),
      on_serving_(std::move(on_serving)),
      protection_(open_protection(settings)),
      rights_(settings.rights),
      ros2_rules_(settings.ros2 ? read_ros2_rules(settings.ros2->rules_file)
                                : std::vector<ros2::Rule>{}),
      options_(member_options(settings)),
      moved_(
          io, [this](const Endpoint& a) { return !member_ || member_->may_announce(a); },
          [](const Endpoint& a, const boost::system::error_code& why) {
              spdlog::warn("{} goes from this machine, it cannot be added again: {}",
                           net::to_text(a), why.message());
          }),
      turns_(net::TurnClock::of(io)),
      udp_(io, *this),
      timer_(io, [this] { on_core_wakeup(); }),
      look_timer_(io, [this] { look_around(); }),
      later_life_timer_(io, [this] { begin_again(); }),
      heap_limit_(settings.limits.memory_mib),
      standstill_(settings.cluster->detection_timeout) {
    if (settings_.cluster->condition_file) condition_.emplace(*settings_.cluster->condition_file);
    if (make_uplink != nullptr) open_uplink(make_uplink);
    if (settings.ros2) open_ros2();
    open_addresses();
    open_transport();
    if (options_.cluster.detector == "link") open_links();
    if (!held_.empty()) wait_for_the_holders();
    start_member();
}

void ClusterBroker::open_addresses() {
    for (const Endpoint& address : settings_.listen) {
        Endpoint bound = address;
        net::MovedAddresses::forget_earlier_life(address);
        const auto error = udp_.open(address, net::Bind::alone, &bound);
        if (!error) {
            if (!net::is_wildcard(bound)) moved_.announce(bound);
        } else if (error == boost::system::errc::address_not_available &&
                   net::MovedAddresses::can_add(address)) {
            // Given to the machine as soon as it is clear that no peer serves it now.
            held_.push_back(address);
            held_by_peers_.push_back(address);
        } else if (error == boost::system::errc::address_in_use && !net::is_wildcard(address)) {
            held_.push_back(address);
        } else if (error == boost::system::errc::address_not_available &&
                   net::interface_towards(address) && !net::may_add_addresses()) {
            throw Refusal("--listen '" + net::to_text(address) +
                          "': is no address of this machine, and the right to add it, "
                          "CAP_NET_ADMIN, is missing; as a service switch address-takeover.conf "
                          "on, else start as root, or choose an address that `ip address` lists");
        } else {
            throw Refusal(why_not_served(address, error));
        }
        listen_.push_back(bound);
        // Peers can take over an address, not "all addresses of a machine".
        if (!net::is_wildcard(bound)) options_.home_addresses.push_back(bound);
    }
    if (held_.empty()) join_discovery_groups(udp_, settings_);
    warn_of_shared_addresses();
    warn_of_missing_right();
}

// Peers with such addresses as ours have them on other machines, as a rule.
void ClusterBroker::warn_of_missing_right() const {
    const bool moves = std::ranges::any_of(options_.home_addresses, [](const Endpoint& address) {
        return net::interface_towards(address).has_value();
    });
    if (moves && !net::may_add_addresses()) spdlog::warn("{}", missing_right);
}

// What moves to another machine is not there any more for anything else.
void ClusterBroker::warn_of_shared_addresses() const {
    Endpoint own = net::interface_address(settings_.cluster->interface);
    for (const Endpoint& address : options_.home_addresses) {
        own.port = address.port;
        if (address != own || !net::interface_towards(address)) continue;
        spdlog::warn(
            "{} is also where peers reach this machine: they can take it over, but not hand it "
            "back; serve clients at an address of their own",
            net::to_text(address));
    }
}

void ClusterBroker::open_transport() {
    const ClusterSettings& cluster = *settings_.cluster;
    expect_low_descriptors();
    try {
        const bool over_ipv6 =
            net::interface_address(cluster.interface).family == Endpoint::Family::ipv6;
        domain_ = std::make_unique<dds::Domain>(
            dds::DomainOptions{cluster.domain, cluster.interface, over_ipv6,
                               cluster.is_protected ? peer_papers(*settings_.keys) : std::nullopt});
        const broker::LogId log{broker::broker_id_of(options_.name), options_.incarnation};
        const overlay::Pulses pulses(options_.cluster.beacon_every,
                                     options_.cluster.detection_timeout);
        transport_ = std::make_unique<dds::DdsTransport>(
            io_, *domain_, log, pulses, [this] { on_peers_drained(); },
            [this](std::uint64_t incarnation) { on_later_life(incarnation); });
        transport_->start([this](const overlay::Envelope& envelope) { on_peer_message(envelope); });
    } catch (const dds::DdsError& error) {
        throw Refusal("--domain '" + std::to_string(cluster.domain) + "': cannot be joined" +
                      (cluster.interface.empty() ? "" : " on " + cluster.interface) + " (" +
                      error.what() + "); choose another --interface" +
                      (cluster.is_protected ? ", or look at --keys with `romano keys check`" : ""));
    }
}

/// Nobody hears this life, unless that one lives: then two brokers have one name, of which people
/// are told (overlay/cluster/agreement/namesake.h).
void ClusterBroker::on_later_life(std::uint64_t incarnation) {
    if (settings_.least_incarnation != 0) return;  // once: two of one name would go on like that
    const bool listens_already = later_life_ != 0;
    later_life_ = std::max(later_life_, incarnation);
    if (!listens_already) listen_for_namesake();
}

void ClusterBroker::listen_for_namesake() {
    hears_namesake_ = false;
    later_life_timer_.arm(net::now() + options_.cluster.detection_timeout);
}

void ClusterBroker::begin_again() {
    if (hears_namesake_) return listen_for_namesake();  // it may be switched off one day
    spdlog::warn(
        "peers know a later life of this broker, and would not hear this one: the clock of this "
        "machine has gone back; begins again as the next life");
    throw BeginsAgain{later_life_ + most_lives_of_a_process};
}

void ClusterBroker::open_links() {
    const std::string& interface = settings_.cluster->interface;
    links_ = std::make_unique<link::LinkService>(
        io_, broker::LogId{options_.broker.log.broker, options_.incarnation},
        [this](const broker::LogId& process, election::Link link) { on_link(process, link); });
    if (const auto error = links_->open(net::interface_address(interface))) {
        throw Refusal("--detector 'link': cannot listen" +
                      (interface.empty() ? "" : " on " + interface) + " (" + error.message() +
                      "); choose another --interface or --detector");
    }
    options_.link = links_->address();
    options_.link_secret = links_->secret();
}

void ClusterBroker::open_uplink(MakeUplink make_uplink) {
    uplink_ = make_uplink(io_, settings_.uplink->mqtt, link_events());
}

void ClusterBroker::open_ros2() {
    options_.uplink = ros2::uplink_options(ros2_rules_);
    expect_low_descriptors();
    uplink_ = std::make_unique<Ros2Bridge>(io_, *settings_.ros2, ros2_rules_, link_events());
}

uplink::LinkEvents ClusterBroker::link_events() {
    return {.on_up =
                [this](bool resumed) {
                    member_->on_uplink_up(net::now(), resumed, actions_);
                    carry_out();
                },
            .on_down = [this] { member_->on_uplink_down(); },
            .on_answer =
                [this](const broker::LogPosition& position, uplink::Answer answer) {
                    member_->on_uplink_answer(net::now(), position, answer, actions_);
                    carry_out();
                },
            .on_message =
                [this](const uplink::FromRemote& message, std::uint64_t token) {
                    member_->on_uplink_message(net::now(), message, token, actions_);
                    carry_out();
                }};
}

// Somebody has an address that we shall serve: fine if a peer's beacon says that it is the peer's
// for now, or if the holder goes away.
void ClusterBroker::wait_for_the_holders() {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    for (;;) {
        std::erase_if(held_, [&](const Endpoint& address) {
            return !contains(held_by_peers_, address) && !udp_.open(address, net::Bind::alone);
        });
        const auto stranger = std::ranges::find_if(
            held_, [&](const Endpoint& address) { return !contains(held_by_peers_, address); });
        if (stranger == held_.end()) return;
        if (std::chrono::steady_clock::now() >= deadline) {
            throw Refusal("--listen '" + net::to_text(*stranger) +
                          "': is in use by another program, which is no broker of DDS domain " +
                          std::to_string(settings_.cluster->domain) +
                          "; choose a free port or stop that program");
        }
        io_.run_for(20ms);
        io_.restart();
    }
}

void ClusterBroker::start_member() {
    member_ = std::make_unique<overlay::Member>(options_, random_seed());
    obey_rights();
    for (const Endpoint& address : options_.home_addresses) {
        const bool served = !contains(held_, address);
        member_->on_address(net::now(), address, served, actions_);
        if (!served) spdlog::info("{} is not served here yet", net::to_text(address));
    }
    look_around();
    on_core_wakeup();
    say_when_serving();
}

void ClusterBroker::on_datagram(const Endpoint& via, const Endpoint& from, Bytes octets) {
    if (!member_) return;  // clients ask again
    if (protection_) {
        const auto take = [this](const dtls::Message& admitted) {
            on_message(admitted.path.via, admitted.path.from, admitted.octets);
        };
        protection_->admit(net::now(), via, from, octets, actions_.clients, take);
    } else {
        on_message(via, from, octets);
    }
    if (actions_.clients.list().size() >= most_actions_held ||
        actions_.clients.octets_held() >= most_octets_held) {
        carry_out();
    }
}

void ClusterBroker::on_message(const Endpoint& via, const Endpoint& from, Bytes message) {
    member_->on_datagram(net::now(), via, from, message, actions_);
    bad_senders_.look(member_->broker().counters().malformed_total, from, message);
}

void ClusterBroker::on_batch_end() {
    if (member_) carry_out();
}

void ClusterBroker::on_peer_message(const overlay::Envelope& envelope) {
    if (member_) turns_.begin(net::now());  // before that nobody is kept waiting
    if (envelope.from.broker == options_.broker.log.broker) hears_namesake_ = true;
    if (const auto* told = std::get_if<cluster::Particulars>(&envelope.message)) {
        if (!told->wanted) on_particulars(told->beacon);
    } else if (std::holds_alternative<cluster::Heartbeat>(envelope.message)) {
        if (links_) links_->on_heartbeat(envelope.from.broker);
        if (!member_)
            transport_->send({envelope.from.broker, cluster::Particulars{.wanted = true}});
    }
    if (const auto* told = std::get_if<cluster::SecuredTold>(&envelope.message)) {
        if (!protection_) return;
        overlay::on_packets_told(*told, protection_->clients());
        dtls::DtlsClients* dtls = protection_->dtls_clients();
        if (dtls != nullptr) overlay::on_associations_told(*told, *dtls);
    } else if (member_) {
        member_->on_peer_message(net::now(), envelope, actions_);
    }
}

void ClusterBroker::on_particulars(const cluster::Beacon& beacon) {
    if (links_) {
        links_->on_address({beacon.log.broker, beacon.link.process}, beacon.link.endpoint,
                           beacon.link.secret);
    }
    warn_of_missing_keys(beacon);
    if (member_) {
        for (const Endpoint& address : beacon.home_addresses) on_home_of_peer(address);
        return;
    }
    for (const Endpoint& address : beacon.home_addresses) {
        const bool is_ours = beacon.log.broker == options_.broker.log.broker;
        if (is_ours || !contains(held_, address)) continue;
        throw Refusal("--listen '" + net::to_text(address) + "': is what broker " + beacon.name +
                      " listens on, too; brokers of one cluster have an address each");
    }
    for (const Endpoint& address : beacon.serving) {
        if (contains(held_, address) && !contains(held_by_peers_, address)) {
            held_by_peers_.push_back(address);
        }
    }
}

void ClusterBroker::on_peers_drained() {
    if (!member_) return;
    tell_of_usage();
    carry_out();
}

void ClusterBroker::tell_of_usage() {
    constexpr std::int64_t most = std::numeric_limits<std::uint32_t>::max();
    const std::int64_t longest_us = turns_.longest(net::now()) / std::chrono::microseconds{1};
    const auto& counters = transport_->counters();
    member_->on_usage({.transport_octets_sent = counters.sent_octets,
                       .transport_octets_received = counters.received_octets,
                       .longest_turn_us = static_cast<std::uint32_t>(std::min(longest_us, most)),
                       .cpu_percent = processor_load_.percent()});
}

void ClusterBroker::on_link(const broker::LogId& process, election::Link link) {
    turns_.begin(net::now());
    if (!member_) return;
    member_->on_link(net::now(), process, link, actions_);
    carry_out();
}

void ClusterBroker::on_core_wakeup() {
    const Instant now = net::now();
    const Duration worked_before = thread_processor_time();
    standstill_.look(now, member_->next_wakeup(), worked_before);
    member_->on_tick(now, actions_);
    act();
    if (member_->may_rest()) {
        const Duration rest = rest_per_turn * (thread_processor_time() - worked_before);
        rests_until_ = net::now() + std::min(rest, options_.cluster.beacon_every / 5);
    }
    timer_.arm(next_turn());
}

/// While many sessions move and nobody waits for them, much of the processor is left to others: to
/// whom somebody talks, and to those on this machine who read of the sessions. Beacons and what
/// else is due wait for so long, so it is never long.
Instant ClusterBroker::next_turn() const {
    const Instant wanted = member_->next_wakeup();
    return member_->may_rest() ? std::max(wanted, rests_until_) : wanted;
}

void ClusterBroker::on_home_of_peer(const Endpoint& address) {
    if (homes_of_peers_.size() >= most_homes_of_peers || !homes_of_peers_.insert(address).second) {
        return;
    }
    member_->on_ability(address, can_serve(address));
}

// What changes without telling us: interfaces, and the battery.
/// Also in a dead peer's place it speaks plain, or for clients with keys, only as it was told.
bool ClusterBroker::may_serve(const Endpoint& address) const {
    if (address.packets == Endpoint::Packets::sealed) return protection_ != nullptr;
    if (address.packets == Endpoint::Packets::dtls) {
        return protection_ && protection_->dtls_clients() != nullptr;
    }
    return settings_.allow_plain || net::is_loopback(address);
}

bool ClusterBroker::can_serve(const Endpoint& address) const {
    return may_serve(address) && net::MovedAddresses::can_serve(address);
}

/// Once.
void ClusterBroker::warn_of_missing_keys(const cluster::Beacon& beacon) {
    const auto& homes = beacon.home_addresses;
    const auto keyed = std::ranges::find_if(
        homes, [](const Endpoint& each) { return each.packets != Endpoint::Packets::plain; });
    if (protection_ || keyed == homes.end() || !not_served_.insert(*keyed).second) return;
    spdlog::warn(
        "broker {} serves {}, and this one has no --keys: it cannot stand in for it, and whoever "
        "reaches a plain address here can speak in the names of its clients",
        beacon.name, net::to_text(*keyed));
}

void ClusterBroker::look_around() {
    const bool are_keys_changed = protection_ && protection_->look();
    if (rights_.look(member_->broker()) || are_keys_changed) obey_rights();
    for (const Endpoint& address : homes_of_peers_) {
        member_->on_ability(address, can_serve(address));
    }
    if (protection_) {
        protection_->on_time(net::now(), actions_.clients);
        if (!actions_.clients.empty()) carry_out();
    }
    processor_load_.on_reading(net::now(), process_processor_time());
    tell_of_usage();
    const auto reading = condition_ ? condition_->look() : std::nullopt;
    if (reading) {
        member_->on_condition(net::now(), *reading, actions_);
        carry_out();
    }
    look_timer_.arm(net::now() + look_every);
}

void ClusterBroker::obey_rights() {
    member_->set_rights(rights_.for_owners_of_keys(protection_.get()), rights_.digest());
}

void ClusterBroker::read_rights_again() {
    rights_.read_again();
    if (member_) obey_rights();
}

void ClusterBroker::carry_out() {
    act();
    timer_.arm(next_turn());
}

void ClusterBroker::act() {
    // An address that was taken or not is news for the member, which may want more done.
    for (;;) {
        carry_out_locally();
        if (protection_) tell_packets();
        dds::pack(actions_.peers);
        for (const auto& outgoing : actions_.peers) transport_->send(outgoing);
        member_->before_sending(net::now(), actions_);
        if (protection_) seal();
        udp_.carry_out(actions_.clients);
        for (const auto& action : actions_.uplink) uplink_->carry_out(action);
        actions_.clear();
        if (answers_.empty()) break;
        for (const Answer& answer : answers_) {
            member_->on_address(net::now(), answer.address, answer.served, actions_);
        }
        answers_.clear();
    }
    member_->set_full(heap_limit_.is_reached());
}

void ClusterBroker::tell_packets() {
    const cluster::ViewNumber& view = member_->view().number;
    dtls::DtlsClients* dtls = protection_->dtls_clients();
    if (view != told_in_) {
        protection_->clients().tell_all();
        if (dtls != nullptr) dtls->tell_all();
    }
    told_in_ = view;
    overlay::tell_packets(protection_->clients(), actions_.peers);
    if (dtls != nullptr) overlay::tell_associations(*dtls, actions_.peers);
}

/// That this broker begins to speak by an association is known to the peers before its first record
/// leaves.
void ClusterBroker::seal() {
    protection_->seal(actions_.clients);
    dtls::DtlsClients* dtls = protection_->dtls_clients();
    if (dtls == nullptr || !dtls->has_news()) return;
    std::vector<cluster::Outgoing> news;
    overlay::tell_associations(*dtls, news);
    for (const auto& outgoing : news) transport_->send(outgoing);
}

void ClusterBroker::carry_out_locally() {
    for (const auto& action : actions_.local) {
        if (const auto* take = std::get_if<overlay::TakeAddress>(&action)) {
            const auto error = may_serve(take->address)
                                   ? serve_moved(udp_, moved_, take->address)
                                   : make_error_code(boost::system::errc::permission_denied);
            if (error) {
                warn_of_not_serving(take->address, error);
            } else {
                not_served_.erase(take->address);
                spdlog::info("serving {}", net::to_text(take->address));
            }
            answers_.push_back({take->address, !error});
            if (!error && std::erase(held_, take->address) > 0) on_home_address_returned();
        } else if (const auto* give_up = std::get_if<overlay::GiveUpAddress>(&action)) {
            udp_.close(give_up->address);
            std::erase_if(answers_,
                          [&](const Answer& answer) { return answer.address == give_up->address; });
            moved_.remove(give_up->address);
            spdlog::info("no longer serving {}", net::to_text(give_up->address));
        } else if (const auto* announced = std::get_if<overlay::AnnounceAddress>(&action)) {
            moved_.announce(announced->address);
        } else {
            const auto& notice = std::get<overlay::Notice>(action);
            spdlog::log(notice.is_warning ? spdlog::level::warn : spdlog::level::info, "{}",
                        notice.text);
        }
    }
}

/// Once: it is tried twice a second.
void ClusterBroker::warn_of_not_serving(const Endpoint& address,
                                        const boost::system::error_code& error) {
    if (!not_served_.insert(address).second) return;
    const bool lacks_right = net::interface_towards(address) && !net::may_add_addresses();
    const std::string why = !may_serve(address) ? not_allowed
                            : lacks_right       ? missing_right
                                                : error.message();
    spdlog::warn("cannot serve {}, clients must find another broker: {}", net::to_text(address),
                 why);
}

void ClusterBroker::on_home_address_returned() {
    if (!held_.empty()) return;
    try {
        join_discovery_groups(udp_, settings_);
    } catch (const Refusal& refused) {
        spdlog::warn("{}", refused.what());  // too late to refuse to start
    }
    say_when_serving();
}

void ClusterBroker::say_when_serving() {
    if (!held_.empty() || !on_serving_) return;
    const ClusterSettings& cluster = *settings_.cluster;
    std::exchange(on_serving_, {})(
        {.addresses = listen_,
         .cluster = "domain " + std::to_string(cluster.domain) +
                    (cluster.interface.empty() ? "" : " on " + cluster.interface) +
                    (cluster.is_protected ? ", protected" : "") + listening(options_.cluster)});
}

void ClusterBroker::add_metrics(metrics::Page& page) const {
    metrics::add_datagrams(page, udp_.counters());
    heap_limit_.add_metrics(page);
    metrics::add_wakeups(page, timer_);
    metrics::add_turns(page, turns_, net::now());
    add_transport(page, *transport_);
    if (!member_) return;
    metrics::add_messages(page, member_->broker().counters());
    metrics::add_census(page, member_->broker().census());
    const overlay::MemberFacts facts = member_->facts();
    add_cluster(page, facts);
    if (uplink_) uplink_->add_metrics(page, *facts.uplink);
    if (protection_) protection_->add_metrics(page);
}

void ClusterBroker::leave() {
    if (protection_) protection_->leave();
    member_->leave(net::now(), actions_);
    carry_out();
    io_.stop();
}

}  // namespace romano::daemon
