#include "overlay/member/member.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace romano::overlay {

using broker::BrokerCore;
using broker::LogId;
using cluster::HeldOutput;
using cluster::WaitingInput;

Member::Member(const MemberOptions& options, std::uint64_t seed)
    : options_(options),
      seed_(seed),
      log_{broker::broker_id_of(options.name), options.incarnation},
      broker_(broker_options(), seed),
      server_(options.name, options.broker.unix_time_at_zero),
      cluster_(options.cluster,
               {.name = options.name,
                .log = log_,
                .home_addresses = options.home_addresses,
                .link = {options.link, options.incarnation, options.link_secret},
                .predefined = options.broker.predefined_topics},
               seed + 1) {
    acquaint_broker();
    if (options.uplink) uplink_.emplace(*options.uplink, seed ^ options.incarnation);
}

broker::BrokerOptions Member::broker_options() const {
    broker::BrokerOptions options = options_.broker;
    options.log = log_;
    options.writes_log = true;
    if (options_.romano) {
        options.observed_topics = broker::CarriedServer::observed_topics();
        options.never_retained = broker::CarriedServer::is_never_retained;
    }
    if (options_.uplink) options.read_by_owner = options_.uplink->session;
    return options;
}

void Member::acquaint_broker() {
    broker_.set_audience(cluster_.audience());
    broker_.set_silence([this](const broker::SessionHeader& client, Instant now) {
        // Asked where an exchange would begin: as soon as the lease is back it shall.
        const bool waits = speaking().has_lost_lease(now);
        if (waits) begins_from_ = 0;
        const bool is_silent = speaking().is_silent(client.via);
        if (is_silent) cluster_.on_awaited(client);
        return waits || is_silent;
    });
}

void Member::set_rights(const broker::Permissions* permissions, const std::string& digest) {
    permissions_ = permissions;
    broker_.set_permissions(permissions);
    cluster_.on_rights(digest);
}

// --- inputs

template <typename Act>
void Member::on_input(Instant now, MemberActions& out, Act&& act) {
    if (has_left_) return;
    notice_standstill(now, out);
    act();
    carry_out(now, out);
}

void Member::on_datagram(Instant now, const Endpoint& via, const Endpoint& from, Bytes datagram,
                         MemberActions& out) {
    if (has_left_) return;
    notice_standstill(now, out);
    if (speaking().is_deaf(via)) return;  // its sessions are with another broker by now
    if (!cluster_.is_in_view() && now < fresh_from_) return;
    const auto hold = [&] {
        waiting_.hold(via, from, datagram, true, broker_.has_session_at(via, from, datagram));
    };
    if (speaking().must_wait(now, broker_, via, from, datagram)) {
        cluster_.hurry(effects(now, out), via, from, datagram);
        return hold();
    }
    if (waiting_.holds(from)) {
        hold();
        return carry_out(now, out);
    }
    if (cluster_.must_fetch(effects(now, out), via, from, datagram)) {
        return waiting_.hold(via, from, datagram, false);
    }
    broker_.on_datagram(now, via, from, datagram, work_);
    carry_out(now, out);
}

void Member::on_peer_message(Instant now, const Envelope& envelope, MemberActions& out) {
    on_input(now, out, [&] {
        const cluster::ViewNumber before = cluster_.view().number;
        cluster_.on_message(effects(now, out), envelope);
        if (stood_still_ && cluster_.view().number != before) {
            waiting_.clear();
            cluster_.say_again_everywhere();  // answers were among it
        }
        if (cluster_.was_replaced(now)) restart(now, out);
    });
}

void Member::on_address(Instant now, const Endpoint& address, bool served, MemberActions& out) {
    on_input(now, out, [&] { cluster_.on_address(effects(now, out), address, served); });
}

void Member::on_link(Instant now, const LogId& process, election::Link link, MemberActions& out) {
    on_input(now, out, [&] { cluster_.on_link(effects(now, out), process, link); });
}

void Member::on_condition(Instant now, std::uint32_t reading, MemberActions& out) {
    on_input(now, out, [&] { cluster_.on_condition(effects(now, out), reading); });
}

void Member::on_tick(Instant now, MemberActions& out) {
    if (has_left_) return;
    notice_standstill(now, out);
    broker_.set_congested(cluster_.is_short_of_peers());
    note_lease(now);
    broker_waits_ = speaking().has_lost_lease(now);
    if (!broker_waits_) {
        broker_.on_tick(now, work_, [&](const broker::SessionHeader& client) {
            const Endpoint& from = client.address.endpoint;
            return waiting_.holds(from) || speaking().is_unheard(client.via) ||
                   may_be_elsewhere(client);
        });
    }
    if (options_.romano && cluster_.is_in_view()) {
        const cluster::View& view = cluster_.view();
        const bool leads = view.number.leader == log_.broker;
        const auto led = leads ? std::span{view.members} : std::span<const LogId>{};
        server_.on_tick(now, broker_, led, work_);
    }
    absorb(now, out);  // what it appended stands in the log before the cluster looks at it
    cluster_.on_tick(effects(now, out), held_.addresses());
    status_.on_tick(now, cluster_, broker_, work_);
    catch_up(now, out);
    carry_out(now, out);
    tend_uplink(now, out);
}

Instant Member::next_wakeup() const {
    if (has_left_) return never;
    // The server's turns come with the beacons'. So does the moment in which a lost lease is back.
    const Instant cluster = cluster_.next_wakeup();
    if (broker_waits_) return cluster;
    const bool is_behind = begins_from_ || waiting_.is_behind() || held_.is_behind();
    return is_behind ? Instant::min() : std::min(broker_.next_wakeup(), cluster);
}

void Member::leave(Instant now, MemberActions& out) {
    cluster_.leave(effects(now, out));
    carry_out(now, out);
    release_output(now, std::numeric_limits<std::size_t>::max(), out);  // there is no next turn
    has_left_ = true;  // whatever it said now would call it back
}

// --- while others may have gone on for us

/// Waits until members echo again. Whoever was replaced meanwhile begins anew, and forgets it.
void Member::before_sending(Instant now, MemberActions& out) {
    if (has_left_) return;
    note_lease(now);
    if (speaking().has_lost_lease(now)) hold_output(out);
}

void Member::note_lease(Instant now) {
    const bool spoke = std::exchange(speaks_, may_speak(now));
    if (spoke && !speaks_) ++leases_lost_;
}

void Member::hold_output(MemberActions& out) {
    for (const broker::Action& action : out.clients.list()) {
        const auto* decided = std::get_if<broker::Send>(&action);
        if (decided == nullptr) continue;
        broker::Send send = *decided;
        send.after = 0;  // it was safe
        held_.hold(send, out.clients.octets(*decided));
    }
    out.clients.clear();
}

/// One that is in no view, or comes into another one, does not know how long its clients have been
/// served elsewhere, and what they said meanwhile was answered there: they say it again.
void Member::notice_standstill(Instant now, MemberActions& out) {
    if (!cluster_.notice_standstill(now)) return;
    before_sending(now, out);
    fresh_from_ = now + options_.cluster.beacon_every;
    stood_still_ = true;
    if (!cluster_.is_in_view()) waiting_.clear();
}

/// The others may hear it, on whose side of a cut more are.
bool Member::may_be_elsewhere(const broker::SessionHeader& client) const {
    const auto& since = cluster_.on_smaller_side_since();
    if (!since) return false;
    const Duration unix_time = since->time_since_epoch() + options_.broker.unix_time_at_zero;
    return client.last_heard.unix_ms() <
           static_cast<std::uint64_t>(unix_time / std::chrono::milliseconds{1});
}

/// Others have our sessions and addresses: begin anew, empty, under a new log, and get them back.
void Member::restart(Instant now, MemberActions& out) {
    out.local.push_back(Notice{"was replaced while it stood still: joins again"});
    held_.clear();
    waiting_.clear();  // of sessions that have lived on elsewhere since
    work_.clear();
    ++log_.incarnation;
    ++replacements_;
    const auto retained = broker_.retained();
    broker_ = BrokerCore(broker_options(), seed_ + log_.incarnation);
    acquaint_broker();
    broker_.set_permissions(permissions_);
    if (uplink_) uplink_->abandon(out.uplink);
    late_message_.reset();
    for (const auto& message : retained) broker_.put_retained(message);
    status_.forget();
    cluster_.restart(effects(now, out), log_);
}

// --- the broker core's actions

void Member::carry_out(Instant now, MemberActions& out) {
    absorb(now, out);
    for (const auto& action : out.local) {
        if (const auto* left = std::get_if<GiveUpAddress>(&action)) waiting_.drop(left->address);
    }
    if (!waiting_.is_behind()) serve_waiting(now, out);
    if (speaking().has_lost_lease(now)) return;
    broker_waits_ = stood_still_ = false;
    if (begins_from_) {
        begins_from_ =
            broker_.begin_waiting(now, *begins_from_, options_.cluster.sessions_per_turn, work_);
        absorb(now, out);
    }
    go_on_uplink(now, out);
    if (!held_.is_behind()) release_output(now, options_.cluster.events_per_turn, out);
}

/// With what did not fit the last turn: thousands may have waited for a lease.
void Member::catch_up(Instant now, MemberActions& out) {
    if (waiting_.is_behind()) serve_waiting(now, out);
    if (held_.is_behind()) release_output(now, options_.cluster.events_per_turn, out);
}

void Member::release_output(Instant now, std::size_t most, MemberActions& out) {
    if (speaking().has_lost_lease(now)) return;
    const auto fate_of = [&](const Endpoint& via) { return speaking().said_from(now, via); };
    held_.release(cluster_.safe(now), fate_of, most, out.clients);
}

void Member::absorb(Instant now, MemberActions& out) {
    server_.answer(now, broker_, work_);
    broker::Seq awaited = uplink_ ? uplink_->awaits() : 0;
    for (broker::Action& action : work_.list()) {
        if (const auto* datagram = std::get_if<broker::Send>(&action)) {
            awaited = std::max(awaited, datagram->after);
        } else if (const auto* append = std::get_if<broker::Append>(&action)) {
            cluster_.append(append->seq, append->event);
        } else if (const auto* forward = std::get_if<broker::Forward>(&action)) {
            cluster_.forward(forward->message, out.peers);
        } else if (const auto* for_owner = std::get_if<broker::ForOwner>(&action)) {
            if (uplink_) uplink_->on_for_owner(for_owner->message, out.uplink);
        } else if (auto* note = std::get_if<broker::Note>(&action)) {
            out.local.push_back(Notice{std::move(*note->text), true});
        }
    }
    cluster_.flush(awaited, out.peers);
    const broker::Seq safe = cluster_.safe(now);
    for (const broker::Action& action : work_.list()) {
        if (const auto* datagram = std::get_if<broker::Send>(&action)) {
            send(now, *datagram, safe, out);
        } else if (const auto* multicast = std::get_if<broker::Multicast>(&action)) {
            if (speaking().has_lost_lease(now)) continue;
            out.clients.push(*multicast, work_.octets(*multicast));
        }
    }
    work_.clear();
}

void Member::send(Instant now, const broker::Send& send, broker::Seq safe, MemberActions& out) {
    if (send.to.endpoint == broker::owner_endpoint) return;
    const HeldOutput::Fate fate = speaking().said_from(now, send.via);
    if (fate == HeldOutput::Fate::is_dropped) return;
    if (fate == HeldOutput::Fate::waits) held_.detain(send.to);
    const Bytes octets = work_.octets(send);
    if (send.after > safe || held_.detains(send.to) || held_.holds_any_through(safe)) {
        held_.hold(send, octets);
        return;
    }
    out.clients.push(broker::Send{.via = send.via, .to = send.to}, octets);
}

void Member::serve_waiting(Instant now, MemberActions& out) {
    if (waiting_.empty()) return;
    const auto must_wait = [&](const WaitingInput::Datagram& datagram) {
        return speaking().must_wait(now, broker_, datagram.via, datagram.from, datagram.octets) ||
               cluster_.is_fetching(datagram.via, datagram.from);
    };
    auto ready = waiting_.take_unless(must_wait, options_.cluster.events_per_turn);
    std::vector<WaitingInput::Datagram> wait_again;
    for (auto& datagram : ready) {
        if (datagram.is_new) {
            if (speaking().is_deaf(datagram.via)) continue;
            const bool is_gone =
                datagram.was_homed &&
                cluster_.is_elsewhere(broker_, datagram.via, datagram.from, datagram.octets);
            if (is_gone) continue;
            if (cluster_.must_fetch(effects(now, out), datagram.via, datagram.from,
                                    datagram.octets)) {
                datagram.is_new = false;
                wait_again.push_back(std::move(datagram));
                continue;
            }
        }
        broker_.on_datagram(now, datagram.via, datagram.from, datagram.octets, work_);
        absorb(now, out);
    }
    waiting_.put_back(std::move(wait_again));
}

// --- the uplink

void Member::tend_uplink(Instant now, MemberActions& out) {
    if (!uplink_ || speaking().has_lost_lease(now)) return;
    if (const auto late = std::exchange(late_message_, std::nullopt)) {
        on_uplink_message(now, late->first, late->second, out);
    }
    const Endpoint via = options_.home_addresses.empty() ? Endpoint{} : options_.home_addresses[0];
    for (const auto& request : uplink_->requests(now, broker_, cluster_, out.uplink)) {
        on_datagram(now, via, broker::owner_endpoint, request, out);
    }
}

void Member::go_on_uplink(Instant now, MemberActions& out) {
    if (!uplink_) return;
    uplink_->go_on(now, {log_, cluster_.safe(now)}, broker_, work_, out.uplink);
    absorb(now, out);
    if (!uplink_->has_taken()) return;
    // Without a peer to wait for, it is safe already.
    uplink_->go_on(now, {log_, cluster_.safe(now)}, broker_, work_, out.uplink);
    absorb(now, out);
}

void Member::on_uplink_up(Instant now, bool resumed, MemberActions& out) {
    if (!uplink_) return;
    on_input(now, out, [&] { uplink_->on_up(resumed, broker_, out.uplink); });
}

void Member::on_uplink_answer(Instant now, const broker::LogPosition& position,
                              uplink::Answer answer, MemberActions& out) {
    if (!uplink_) return;
    on_input(now, out, [&] { uplink_->on_answer(now, position, answer, broker_, work_); });
}

void Member::on_uplink_message(Instant now, const uplink::FromRemote& message, std::uint64_t token,
                               MemberActions& out) {
    if (!uplink_ || has_left_) return;
    notice_standstill(now, out);
    if (!uplink_->takes_in()) return;
    if (speaking().has_lost_lease(now)) {  // another one may lead by now
        if (token != 0) late_message_.emplace(message, token);
        return;
    }
    uplink_->on_message(now, cluster_.times(), message, token, broker_, work_, out.local);
    carry_out(now, out);
}

// --- for robots and for people

void Member::check_invariants() const {
#ifndef NDEBUG  // all sessions and logs are looked at
    broker_.check_invariants();
    cluster_.check_invariants(broker_);
    assert(work_.empty());
#endif
}

}  // namespace romano::overlay
