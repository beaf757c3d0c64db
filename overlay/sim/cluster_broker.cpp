#include "overlay/sim/cluster_broker.h"

#include <chrono>
#include <utility>
#include <variant>

#include "overlay/associations_told.h"
#include "overlay/packets_told.h"
#include "overlay/sim/seed.h"

namespace romano::sim {

using namespace std::chrono_literals;

namespace {

Endpoint plain(Endpoint address) {
    address.packets = Endpoint::Packets::plain;
    return address;
}

std::uint64_t octets_of(const TrafficByDelivery& traffic) {
    std::uint64_t octets = 0;
    for (const auto& [delivery, counted] : traffic) octets += counted.octets;
    return octets;
}

}  // namespace

ClusterBroker::ClusterBroker(const ClusterBrokerOptions& options, EventQueue& events,
                             ClientNetwork& clients, BrokerNetwork& peers, Trace& trace,
                             std::uint64_t seed)
    : BrokerProcess(options.name, options.node, events, clients, trace, seed, options.machine),
      options_(options),
      seed_(seed),
      clients_(clients),
      peers_(peers),
      pulses_(options.cluster.beacon_every, options.cluster.detection_timeout) {}

Endpoint ClusterBroker::as_service(Endpoint address) const {
    if (protection_) address.packets = Endpoint::Packets::sealed;
    if (dtls_) address.packets = Endpoint::Packets::dtls;
    return address;
}

void ClusterBroker::create_protection() {
    told_in_ = {};
    if (options_.dtls != nullptr) {
        const auto place = static_cast<std::uint32_t>(options_.node) + 1;
        dtls_.emplace(name() + '.' + std::to_string(incarnation()), place, disk_.bound,
                      *options_.dtls, options_.clients, seed_of(seed_, "dtls", incarnation()));
        store_bound(dtls_->reserve());
    }
    if (options_.sealed == nullptr) return;
    const auto identity = static_cast<std::uint8_t>(options_.node);
    protection_ = std::make_unique<broker::ProtectedClients>(protection::SenderId{0xB0, identity},
                                                             disk_.bound);
    protection_->set_clients(options_.clients, [this](const protection::SenderId& sender) {
        const auto found = disk_.heard.find(sender);
        return found == disk_.heard.end() ? std::nullopt : std::optional{found->second};
    });
}

/// Before anything is done that depends on it.
void ClusterBroker::keep_on_disk() {
    if (const auto heard = protection_->to_store()) {
        disk_.heard.insert_or_assign(heard->sender, heard->heard);
        protection_->on_stored();
    }
    store_bound(protection_->reserve());
}

void ClusterBroker::store_bound(protection::Reserve& reserve) {
    const auto bound = reserve.to_store();
    if (!bound) return;
    disk_.bound = *bound;
    reserve.on_stored(*bound);
}

void ClusterBroker::tell_and_seal(overlay::MemberActions& actions) {
    const cluster::ViewNumber& view = member_->view().number;
    const bool is_new_view = std::exchange(told_in_, view) != view;
    if (protection_) {
        if (is_new_view) protection_->tell_all();
        overlay::tell_packets(*protection_, actions.peers);
        seal(actions.clients);
    }
    if (dtls_) {
        if (is_new_view) dtls_->clients().tell_all();
        overlay::tell_associations(dtls_->clients(), actions.peers);
        store_bound(dtls_->reserve());
        dtls_->seal(actions.clients);
        if (!dtls_->clients().has_news()) return;  // that it begins to speak
        overlay::tell_associations(dtls_->clients(), actions.peers);
    }
}

void ClusterBroker::seal(broker::Actions& actions) {
    keep_on_disk();
    protection_->seal(actions);
    for (const broker::Action& action : actions.list()) {
        const auto* out = std::get_if<broker::Send>(&action);
        if (out == nullptr) continue;
        const std::string& node_id = out->to.wireless_node_id;
        options_.sealed->on_sealed(node_id.substr(node_id.find(':') + 1),
                                   SealedPackets::Way::to_robot, actions.octets(*out));
    }
}

void ClusterBroker::create_core() {
    create_protection();
    // All wall clocks say nearly the same although the monotonic ones began at different times.
    const Duration wall = 20'000h + events_.now().time_since_epoch() + options_.wall_clock_error;
    const broker::LogId log{broker::broker_id_of(name()), static_cast<std::uint64_t>(wall.count())};
    overlay::MemberOptions member{.broker = options_.broker,
                                  .cluster = options_.cluster,
                                  .name = name(),
                                  .incarnation = log.incarnation,
                                  .home_addresses = {}};
    for (const Endpoint& address : options_.home_addresses) {
        member.home_addresses.push_back(as_service(address));
    }
    member.broker.unix_time_at_zero = wall - local_now().time_since_epoch();
    BrokerNetwork::OnLink on_link;
    if (options_.cluster.detector == "link") {
        on_link = [this](const broker::LogId& process, election::Link link) {
            later(Duration{0}, [this, process, link] { take(process, link); });
        };
    }
    member_ = std::make_unique<overlay::Member>(member, seed_of(seed_, "member", incarnation()));
    take_up_rights();
    sent_before_ = octets_of(peers_.sent_by(node()));
    received_before_ = octets_of(peers_.received_by(node()));
    transport_ = peers_.attach(log, node(), std::move(on_link));
    transport_->start([this](const cluster::Envelope& envelope) { on_envelope(envelope); });
    for (const Endpoint& address : options_.home_addresses) {
        const bool is_free = !clients_.is_bound(address);
        if (is_free) bind(address);
        answer_address(address, is_free);
    }
}

void ClusterBroker::take_up_rights() {
    if (options_.rights == nullptr) return;
    const auto [permissions, digest] = options_.rights->in_force();
    member_->set_rights(permissions, digest);
}

void ClusterBroker::hear_of_rights() {
    if (!is_up()) return;
    later(Duration{0}, [this] {
        take_up_rights();
        options_.rights->on_taken_up(events_.now());
        trace_.note(events_.now(), name(), "has new rights");
    });
}

void ClusterBroker::destroy_core() {
    wanted_.clear();
    protection_.reset();
    dtls_.reset();
    pulses_.end();
    transport_.reset();
    member_.reset();
    leaving_ = false;
}

void ClusterBroker::on_stop_core() {
    is_pulsing_ = true;
    pulse_later();
}

void ClusterBroker::on_go_on() {
    is_pulsing_ = false;
    peers_.go_on(node());
}

void ClusterBroker::pulse_later() {
    if (pulses_.next() == never) return;
    const Instant next = std::max(pulses_.next(), events_.now());
    events_.at(next, [this, sent_after = pulse_] {
        if (!is_pulsing_ || pulse_.tick != sent_after.tick || pulse_.log != sent_after.log) return;
        if (pulses_.take_due(events_.now())) transport_->send({std::nullopt, pulse_});
        pulse_later();
    });
}

void ClusterBroker::leave() {
    if (!is_running()) return;
    trace_.note(events_.now(), name(), "leaves");
    leaving_ = true;
    member_->leave(local_now(), actions_);
    carry_out();
    if (protection_) {
        for (const auto& [sender, heard] : protection_->heard()) disk_.heard[sender] = heard;
    }
    pulses_.end();
    later(100ms, [this] { crash(); });
}

template <typename Step>
void ClusterBroker::let_member(Step&& step) {
    const auto begun = std::chrono::steady_clock::now();
    step();
    core_time_ += std::chrono::steady_clock::now() - begun;
    carry_out();
}

void ClusterBroker::take(const Datagram& datagram) {
    let_member([&] {
        const Endpoint via = as_service(datagram.via);
        Bytes octets = datagram.octets;
        if (protection_) {
            octets = protection_->admit(local_now(), via, datagram.from, octets, actions_.clients);
            keep_on_disk();
            if (octets.empty()) return;
        }
        if (dtls_) {
            const auto deliver = [this](const dtls::Message& message) {
                member_->on_datagram(local_now(), message.path.via, message.path.from,
                                     message.octets, actions_);
            };
            return dtls_->take({via, datagram.from}, octets, actions_.clients, deliver);
        }
        member_->on_datagram(local_now(), via, datagram.from, octets, actions_);
    });
}

void ClusterBroker::take(const cluster::Envelope& envelope) {
    if (const auto* told = std::get_if<cluster::SecuredTold>(&envelope.message)) {
        if (protection_) overlay::on_packets_told(*told, *protection_);
        if (dtls_) overlay::on_associations_told(*told, dtls_->clients());
        return;
    }
    if (const auto* told = std::get_if<cluster::Particulars>(&envelope.message)) {
        for (const Endpoint& address : told->beacon.home_addresses) {
            member_->on_ability(address, can_serve(plain(address)));
        }
    }
    let_member([&] { member_->on_peer_message(local_now(), envelope, actions_); });
}

void ClusterBroker::take(const broker::LogId& process, election::Link link) {
    member_->on_link(local_now(), process, link, actions_);
    carry_out();
}

void ClusterBroker::tell_of_traffic() {
    if (!peers_.options().octets_of) return;
    member_->on_usage(
        {.transport_octets_sent = octets_of(peers_.sent_by(node())) - sent_before_,
         .transport_octets_received = octets_of(peers_.received_by(node())) - received_before_});
}

void ClusterBroker::tick() {
    tell_of_traffic();
    let_member([&] { member_->on_tick(local_now(), actions_); });
}

void ClusterBroker::answer_address(const Endpoint& address, bool served) {
    member_->on_address(local_now(), as_service(address), served, actions_);
    carry_out();
}

void ClusterBroker::take_address(const Endpoint& address) {
    wanted_.insert(address);
    later(random_.between(0ns, options_.binding_takes_max), [this, address] {
        if (!wanted_.contains(address)) return;  // it was given up before
        if (can_serve(address)) bind(address);
        answer_address(address, can_serve(address));
    });
}

bool ClusterBroker::can_serve(const Endpoint& address) const {
    return options_.serves_others || std::ranges::count(options_.home_addresses, address) > 0;
}

void ClusterBroker::carry_out() {
    overlay::MemberActions actions = std::exchange(actions_, {});
    said_from_.clear();
    tell_and_seal(actions);
    for (const auto& action : actions.local) {
        if (const auto* wanted = std::get_if<overlay::TakeAddress>(&action)) {
            take_address(plain(wanted->address));
        } else if (const auto* given = std::get_if<overlay::GiveUpAddress>(&action)) {
            wanted_.erase(plain(given->address));
            unbind(plain(given->address));
        } else if (const auto* notice = std::get_if<overlay::Notice>(&action)) {
            trace_.note(events_.now(), name(), notice->text);
        }
    }
    for (const cluster::Outgoing& message : actions.peers) {
        if (const auto pulse = cluster::pulse_after(message.message)) {
            pulse_ = *pulse;
            pulses_.on_beacon(events_.now());
        }
        transport_->send(message);
    }
    for (const broker::Action& action : actions.clients.list()) {
        const auto* out = std::get_if<broker::Send>(&action);
        if (out != nullptr && out->via.family != Endpoint::Family::none) {
            said_from_.insert(out->via);
            send(plain(out->via), out->to.endpoint, actions.clients.octets(*out));
        }
    }
    member_->check_invariants();
    if (observer_) observer_();
}

}  // namespace romano::sim
