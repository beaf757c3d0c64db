#include "overlay/sim/cluster_broker.h"

#include <chrono>
#include <utility>
#include <variant>

#include "overlay/sim/seed.h"

namespace romano::sim {

using namespace std::chrono_literals;

ClusterBroker::ClusterBroker(const ClusterBrokerOptions& options, EventQueue& events,
                             ClientNetwork& clients, BrokerNetwork& peers, Trace& trace,
                             std::uint64_t seed)
    : BrokerProcess(options.name, options.node, events, clients, trace, seed, options.machine),
      options_(options),
      seed_(seed),
      clients_(clients),
      peers_(peers),
      pulses_(options.cluster.beacon_every, options.cluster.detection_timeout) {}

void ClusterBroker::create_core() {
    // All wall clocks say nearly the same although the monotonic ones began at different times.
    const Duration wall = 20'000h + events_.now().time_since_epoch() + options_.wall_clock_error;
    const broker::LogId log{broker::broker_id_of(name()), static_cast<std::uint64_t>(wall.count())};
    overlay::MemberOptions member{.broker = options_.broker,
                                  .cluster = options_.cluster,
                                  .name = name(),
                                  .incarnation = log.incarnation,
                                  .home_addresses = options_.home_addresses};
    member.broker.unix_time_at_zero = wall - local_now().time_since_epoch();
    BrokerNetwork::OnLink on_link;
    if (options_.cluster.detector == "link") {
        on_link = [this](const broker::LogId& process, election::Link link) {
            later(Duration{0}, [this, process, link] { take(process, link); });
        };
    }
    member_ = std::make_unique<overlay::Member>(member, seed_of(seed_, "member", incarnation()));
    transport_ = peers_.attach(log, node(), std::move(on_link));
    transport_->start([this](const cluster::Envelope& envelope) { on_envelope(envelope); });
    for (const Endpoint& address : options_.home_addresses) {
        const bool is_free = !clients_.is_bound(address);
        if (is_free) bind(address);
        answer_address(address, is_free);
    }
}

void ClusterBroker::destroy_core() {
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
        member_->on_datagram(local_now(), datagram.via, datagram.from, datagram.octets, actions_);
    });
}

void ClusterBroker::take(const cluster::Envelope& envelope) {
    let_member([&] { member_->on_peer_message(local_now(), envelope, actions_); });
}

void ClusterBroker::take(const broker::LogId& process, election::Link link) {
    member_->on_link(local_now(), process, link, actions_);
    carry_out();
}

void ClusterBroker::tick() {
    let_member([&] { member_->on_tick(local_now(), actions_); });
}

void ClusterBroker::answer_address(const Endpoint& address, bool served) {
    member_->on_address(local_now(), address, served, actions_);
    carry_out();
}

void ClusterBroker::take_address(const Endpoint& address) {
    later(random_.between(0ns, options_.binding_takes_max), [this, address] {
        bind(address);
        answer_address(address, true);
    });
}

void ClusterBroker::carry_out() {
    overlay::MemberActions actions = std::exchange(actions_, {});
    for (const auto& action : actions.local) {
        if (const auto* wanted = std::get_if<overlay::TakeAddress>(&action)) {
            take_address(wanted->address);
        } else if (const auto* given = std::get_if<overlay::GiveUpAddress>(&action)) {
            unbind(given->address);
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
        if (const auto* out = std::get_if<broker::Send>(&action)) {
            send(out->via, out->to.endpoint, actions.clients.octets(*out));
        }
    }
    member_->check_invariants();
    if (observer_) observer_();
}

}  // namespace romano::sim
