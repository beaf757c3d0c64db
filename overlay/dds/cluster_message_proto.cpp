#include "overlay/dds/cluster_message_proto.h"

#include <algorithm>
#include <functional>

#include "overlay/dds/log_event_proto.h"
#include "overlay/dds/session_proto.h"

namespace romano::overlay::proto {
namespace {

using MaybeMessage = std::optional<cluster::ClusterMessage>;

// Each is one more than those before it: nobody gets there, and one more than this is higher.
constexpr std::uint64_t counted_most = std::uint64_t{1} << 62U;

void to_proto(const cluster::ViewNumber& in, ViewNumber& out) {
    out.set_term(in.term);
    out.set_leader(static_cast<std::uint64_t>(in.leader));
    out.set_count(in.count);
}

cluster::ViewNumber number_from(const ViewNumber& in) {
    return {in.term(), broker::BrokerId{in.leader()}, in.count()};
}

void to_proto(const cluster::View& in, View& out) {
    to_proto(in.number, *out.mutable_number());
    all_to_proto(in.members, *out.mutable_members());
}

bool is_in_reach(const cluster::ViewNumber& number) {
    return number.term <= counted_most && number.count <= counted_most;
}

std::optional<cluster::View> from_proto(const View& in) {
    cluster::View out{number_from(in.number()), {}};
    if (!is_in_reach(out.number)) return std::nullopt;
    if (!all_from_proto(in.members(), out.members)) return std::nullopt;
    const auto unsorted = std::ranges::adjacent_find(out.members, std::greater_equal{});
    if (unsorted != out.members.end()) return std::nullopt;
    return out;
}

/// Its figures stand among the others of a heartbeat, and of a beacon.
template <typename Message>
void to_proto(const cluster::Usage& in, Message& out) {
    out.set_transport_octets_sent(in.transport_octets_sent);
    out.set_transport_octets_received(in.transport_octets_received);
    out.set_longest_turn_us(in.longest_turn_us);
    out.set_cpu_percent(in.cpu_percent);
}

template <typename Message>
cluster::Usage usage_from(const Message& in) {
    return {.transport_octets_sent = in.transport_octets_sent(),
            .transport_octets_received = in.transport_octets_received(),
            .longest_turn_us = in.longest_turn_us(),
            .cpu_percent = in.cpu_percent()};
}

void to_proto(const election::Claim& in, Claim& out) {
    out.set_capability(in.rank.capability);
    out.set_condition(in.rank.condition);
    out.set_id(static_cast<std::uint64_t>(in.rank.id));
    out.set_term(in.term);
    if (in.leader) out.set_leader(static_cast<std::uint64_t>(*in.leader));
}

election::Claim claim_from(const Claim& in) {
    election::Claim out{
        {in.capability(), in.condition(), election::NodeId{in.id()}}, in.term(), std::nullopt};
    if (in.has_leader()) out.leader = election::NodeId{in.leader()};
    return out;
}

MaybeMessage read_log_batch(const LogBatch& in) {
    const auto log = from_proto(in.log());
    if (!log) return std::nullopt;
    cluster::LogBatch out{.log = *log, .first_seq = in.first_seq(), .awaited = in.awaited()};
    if (!all_from_proto(in.events(), out.events)) return std::nullopt;
    return out;
}

void to_proto(const cluster::LeftAddress& in, LeftAddress& out) {
    to_proto(in.log, *out.mutable_log());
    to_proto(in.address, *out.mutable_address());
}

std::optional<cluster::LeftAddress> from_proto(const LeftAddress& in) {
    const auto log = from_proto(in.log());
    const auto address = from_proto(in.address());
    if (!log || !address) return std::nullopt;
    return cluster::LeftAddress{*log, *address};
}

void to_proto(const cluster::Assignment& in, Assignment& out) {
    to_proto(in.end, *out.mutable_end());
    to_proto(in.address, *out.mutable_address());
    out.set_heir(static_cast<std::uint64_t>(in.heir));
}

std::optional<cluster::Assignment> from_proto(const Assignment& in) {
    const auto end = from_proto(in.end());
    const auto address = from_proto(in.address());
    if (!end || !address) return std::nullopt;
    return cluster::Assignment{*end, *address, broker::BrokerId{in.heir()}};
}

// One overload a message: writes it as the alternative of the oneof that is its own.
struct MessageWriter {
    ClusterMessage& out;

    void operator()(const cluster::Heartbeat& m) const {
        auto& to = *out.mutable_heartbeat();
        to_proto(m.log, *to.mutable_log());
        to.set_last_seq(m.last_seq);
        to.set_tick(m.tick);
        to.set_particulars(m.particulars);
        to_proto(m.view, *to.mutable_view());
        if (m.promised != m.view) to_proto(m.promised, *to.mutable_promised());
        to_proto(m.claim, *to.mutable_claim());
        to.set_members(m.members);
        to.set_hears_members(m.hears_members.data(), m.hears_members.size());
        to.set_echoes(m.echoes.data(), m.echoes.size());
        for (const auto id : m.hears_others) to.add_hears_others(static_cast<std::uint64_t>(id));
        for (const auto& [member, through] : m.held) {
            to.add_held_members(member);
            to.add_held_through(through);
        }
        all_to_proto(m.held_others, *to.mutable_held_others());
        to.set_logs_held(m.logs_held);
        to.set_sessions(m.sessions);
        to.set_connected(m.connected);
        to_proto(m.usage, to);
        to.set_leaving(m.leaving);
    }
    void operator()(const cluster::Particulars& told) const {
        const cluster::Beacon& m = told.beacon;
        auto& particulars = *out.mutable_particulars();
        particulars.set_wanted(told.wanted);
        if (told.wanted) return;
        for (const auto& setting : told.settings) {
            auto& one = *particulars.add_settings();
            one.set_name(setting.name);
            one.set_value(setting.value);
            one.set_digest(setting.digest);
        }
        auto& to = *particulars.mutable_beacon();
        to.set_name(m.name);
        to_proto(m.log, *to.mutable_log());
        to.set_last_seq(m.last_seq);
        to.set_tick(m.tick);
        to_proto(m.view, *to.mutable_view());
        if (m.promised != m.view.number) to_proto(m.promised, *to.mutable_promised());
        to_proto(m.claim, *to.mutable_claim());
        for (const auto id : m.hears) to.add_hears(static_cast<std::uint64_t>(id));
        for (const cluster::Echo& echo : m.echoes) {
            to_proto(broker::LogPosition{echo.of, echo.tick}, *to.add_echoes());
        }
        for (const auto id : m.vouched) to.add_vouched(static_cast<std::uint64_t>(id));
        all_to_proto(m.applied, *to.mutable_applied());
        all_to_proto(m.ended, *to.mutable_ended());
        all_to_proto(m.home_addresses, *to.mutable_home_addresses());
        all_to_proto(m.serving, *to.mutable_serving());
        all_to_proto(m.binding, *to.mutable_binding());
        to.set_sessions(m.sessions);
        to.set_connected(m.connected);
        to.set_cannot_take(m.cannot_take);
        to_proto(m.usage, to);
        to.set_leaving(m.leaving);
        to_proto(m.link.endpoint, *to.mutable_link());
        to.set_link_process(m.link.process);
        to.set_link_secret(m.link.secret.data(), m.link.secret.size());
        to.set_settings(m.settings);
        to.set_predefined(m.predefined);
    }
    void operator()(const cluster::LogBatch& m) const {
        auto& to = *out.mutable_log_batch();
        to_proto(m.log, *to.mutable_log());
        to.set_first_seq(m.first_seq);
        all_to_proto(m.events, *to.mutable_events());
        to.set_awaited(m.awaited);
    }
    void operator()(const cluster::LogAck& m) const {
        to_proto(m.through, *out.mutable_log_ack()->mutable_through());
        to_proto(m.by, *out.mutable_log_ack()->mutable_by());
    }
    void operator()(const cluster::ForwardBatch& m) const {
        all_to_proto(m.messages, *out.mutable_forward_batch()->mutable_messages());
    }
    void operator()(const cluster::ElectionMessage& m) const {
        auto& to = *out.mutable_ballot();
        to.set_kind(m.ballot.kind);
        to.set_term(m.ballot.term);
    }
    void operator()(const cluster::ViewProposal& m) const {
        auto& to = *out.mutable_view_proposal();
        to_proto(m.view, *to.mutable_view());
        all_to_proto(m.removed, *to.mutable_removed());
    }
    void operator()(const cluster::ViewHoldings& m) const {
        auto& to = *out.mutable_view_holdings();
        to_proto(m.number, *to.mutable_number());
        all_to_proto(m.holds, *to.mutable_holds());
        all_to_proto(m.outdated, *to.mutable_outdated());
        all_to_proto(m.kept_after, *to.mutable_kept_after());
        all_to_proto(m.foreign, *to.mutable_foreign());
        all_to_proto(m.cannot_take, *to.mutable_cannot_take());
        all_to_proto(m.serving, *to.mutable_serving());
        for (const auto& left : m.addresses) to_proto(left, *to.add_addresses());
    }
    void operator()(const cluster::ViewAnnouncement& m) const {
        auto& to = *out.mutable_view_announcement();
        to_proto(m.view, *to.mutable_view());
        for (const auto& assignment : m.assignments) to_proto(assignment, *to.add_assignments());
        all_to_proto(m.ends, *to.mutable_ends());
    }
    void operator()(const cluster::Fetch& m) const {
        to_proto(m.after, *out.mutable_fetch()->mutable_after());
        out.mutable_fetch()->set_to(static_cast<std::uint64_t>(m.to));
    }
    void operator()(const cluster::SnapshotPart& m) const {
        auto& to = *out.mutable_snapshot_part();
        to_proto(m.as_of, *to.mutable_as_of());
        to.set_part(m.part);
        to.set_last(m.last);
        all_to_proto(m.sessions, *to.mutable_sessions());
        all_to_proto(m.retained, *to.mutable_retained());
        all_to_proto(m.publishes, *to.mutable_publishes());
        all_to_proto(m.cursors, *to.mutable_cursors());
        to.set_since(m.since);
        for (const auto& client : m.gone) to.add_gone(client);
        for (const auto& session : m.moved) {
            auto& one = *to.add_moved();
            to_proto(session.image, *one.mutable_image());
            to_proto(session.to, *one.mutable_to());
            one.set_at(session.at);
        }
    }
    void operator()(const cluster::SessionRequest& m) const {
        auto& to = *out.mutable_session_request();
        to.set_client_id(m.client_id);
        to_proto(m.at, *to.mutable_at());
    }
    void operator()(const cluster::Pulse& m) const {
        to_proto(m.log, *out.mutable_pulse()->mutable_log());
        out.mutable_pulse()->set_tick(m.tick);
    }
    void operator()(const cluster::SecuredTold& m) const {
        auto& to = *out.mutable_secured_told();
        for (const auto& client : m.packets) {
            auto& one = *to.add_packets();
            one.set_sender(client.sender);
            one.set_run(client.run);
            one.set_floor(client.floor);
        }
        for (const auto& association : m.associations) {
            auto& one = *to.add_associations();
            one.set_id(association.id);
            one.set_client(association.client);
            to_proto(association.via, *one.mutable_via());
            to_proto(association.from, *one.mutable_from());
            one.set_keys(association.keys.data(), association.keys.size());
            one.set_turn(association.turn);
            one.set_floor(association.floor);
            if (!association.roaming) continue;
            const auto& [id, at] = *association.roaming;
            one.set_roaming_id(id.data(), id.size());
            to_proto(at, *one.mutable_roaming_at());
        }
        for (const auto& progress : m.progress) {
            auto& one = *to.add_progress();
            one.set_id(progress.id);
            one.set_turn(progress.turn);
            one.set_floor(progress.floor);
            one.set_closed(progress.closed);
        }
    }
};

MaybeMessage read_heartbeat(const Heartbeat& in) {
    const auto log = from_proto(in.log());
    if (!log) return std::nullopt;
    cluster::Heartbeat out;
    out.log = *log;
    out.last_seq = in.last_seq();
    out.tick = in.tick();
    out.particulars = in.particulars();
    out.view = number_from(in.view());
    out.promised = in.has_promised() ? number_from(in.promised()) : out.view;
    out.claim = claim_from(in.claim());
    if (!is_in_reach(out.view) || !is_in_reach(out.promised)) return std::nullopt;
    if (out.claim.term > counted_most) return std::nullopt;
    out.members = in.members();
    out.hears_members.assign(in.hears_members().begin(), in.hears_members().end());
    out.echoes.assign(in.echoes().begin(), in.echoes().end());
    for (const auto id : in.hears_others()) out.hears_others.push_back(broker::BrokerId{id});
    if (in.held_members_size() != in.held_through_size()) return std::nullopt;
    for (int i = 0; i < in.held_members_size(); ++i) {
        out.held.push_back({in.held_members(i), in.held_through(i)});
    }
    if (!all_from_proto(in.held_others(), out.held_others)) return std::nullopt;
    out.logs_held = in.logs_held();
    out.sessions = in.sessions();
    out.connected = in.connected();
    out.usage = usage_from(in);
    out.leaving = in.leaving();
    return out;
}

MaybeMessage read_particulars(const Particulars& all) {
    if (all.wanted()) return cluster::Particulars{.wanted = true};
    const Beacon& in = all.beacon();
    const auto log = from_proto(in.log());
    auto view = from_proto(in.view());
    const auto link = from_proto(in.link());
    const std::string& secret = in.link_secret();
    cluster::Beacon out;
    if (!log || !view || !link || secret.size() != out.link.secret.size()) return std::nullopt;
    out.link = {.endpoint = *link, .process = in.link_process()};
    std::ranges::copy(secret, out.link.secret.begin());
    out.name = in.name();
    if (broker::broker_id_of(out.name) != log->broker) return std::nullopt;
    out.log = *log;
    out.last_seq = in.last_seq();
    out.tick = in.tick();
    out.view = std::move(*view);
    out.promised = in.has_promised() ? number_from(in.promised()) : out.view.number;
    out.claim = claim_from(in.claim());
    if (!is_in_reach(out.promised) || out.claim.term > counted_most) return std::nullopt;
    out.sessions = in.sessions();
    out.connected = in.connected();
    out.cannot_take = in.cannot_take();
    out.usage = usage_from(in);
    out.leaving = in.leaving();
    out.settings = in.settings();
    out.predefined = in.predefined();
    for (const auto id : in.hears()) out.hears.push_back(broker::BrokerId{id});
    for (const auto id : in.vouched()) out.vouched.push_back(broker::BrokerId{id});
    for (const auto& echo : in.echoes()) {
        const auto told = from_proto(echo);
        if (!told) return std::nullopt;
        out.echoes.push_back({told->log, told->seq});
    }
    if (!all_from_proto(in.applied(), out.applied)) return std::nullopt;
    if (!all_from_proto(in.ended(), out.ended)) return std::nullopt;
    if (!all_from_proto(in.home_addresses(), out.home_addresses)) return std::nullopt;
    if (!all_from_proto(in.serving(), out.serving)) return std::nullopt;
    if (!all_from_proto(in.binding(), out.binding)) return std::nullopt;
    cluster::Particulars particulars{std::move(out), {}, false};
    for (const auto& setting : all.settings()) {
        particulars.settings.push_back({setting.name(), setting.value(), setting.digest()});
    }
    return particulars;
}

MaybeMessage read_log_ack(const LogAck& in) {
    const auto through = from_proto(in.through());
    const auto by = from_proto(in.by());
    if (!through || !by) return std::nullopt;
    return cluster::LogAck{*through, *by};
}

MaybeMessage read_forward_batch(const ForwardBatch& in) {
    cluster::ForwardBatch out;
    if (!all_from_proto(in.messages(), out.messages)) return std::nullopt;
    return out;
}

MaybeMessage read_ballot(const Ballot& in) {
    const auto kind = narrow<std::uint8_t>(in.kind());
    if (!kind || in.term() > counted_most) return std::nullopt;
    return cluster::ElectionMessage{{*kind, in.term()}};
}

MaybeMessage read_view_proposal(const ViewProposal& in) {
    auto view = from_proto(in.view());
    if (!view) return std::nullopt;
    cluster::ViewProposal out{std::move(*view), {}};
    if (!all_from_proto(in.removed(), out.removed)) return std::nullopt;
    return out;
}

MaybeMessage read_view_holdings(const ViewHoldings& in) {
    cluster::ViewHoldings out{.number = number_from(in.number())};
    if (!all_from_proto(in.holds(), out.holds)) return std::nullopt;
    if (!all_from_proto(in.outdated(), out.outdated)) return std::nullopt;
    if (!all_from_proto(in.kept_after(), out.kept_after)) return std::nullopt;
    if (!all_from_proto(in.foreign(), out.foreign)) return std::nullopt;
    if (!all_from_proto(in.cannot_take(), out.cannot_take)) return std::nullopt;
    if (!all_from_proto(in.serving(), out.serving)) return std::nullopt;
    for (const auto& item : in.addresses()) {
        const auto left = from_proto(item);
        if (!left) return std::nullopt;
        out.addresses.push_back(*left);
    }
    return out;
}

MaybeMessage read_view_announcement(const ViewAnnouncement& in) {
    auto view = from_proto(in.view());
    if (!view) return std::nullopt;
    cluster::ViewAnnouncement out{std::move(*view), {}, {}};
    for (const auto& item : in.assignments()) {
        const auto assignment = from_proto(item);
        if (!assignment) return std::nullopt;
        out.assignments.push_back(*assignment);
    }
    if (!all_from_proto(in.ends(), out.ends)) return std::nullopt;
    return out;
}

MaybeMessage read_snapshot_part(const SnapshotPart& in) {
    const auto as_of = from_proto(in.as_of());
    if (!as_of) return std::nullopt;
    cluster::SnapshotPart out{
        .as_of = *as_of, .since = in.since(), .part = in.part(), .last = in.last()};
    out.gone.assign(in.gone().begin(), in.gone().end());
    if (!all_from_proto(in.sessions(), out.sessions)) return std::nullopt;
    if (!all_from_proto(in.retained(), out.retained)) return std::nullopt;
    if (!all_from_proto(in.publishes(), out.publishes)) return std::nullopt;
    if (!all_from_proto(in.cursors(), out.cursors)) return std::nullopt;
    for (const MovedSession& session : in.moved()) {
        auto image = from_proto(session.image());
        const auto to = from_proto(session.to());
        if (!image || !to) return std::nullopt;
        out.moved.push_back({*std::move(image), *to, session.at()});
    }
    return out;
}

MaybeMessage read_secured_told(const SecuredTold& in) {
    cluster::SecuredTold out;
    for (const auto& client : in.packets()) {
        out.packets.push_back({client.sender(), client.run(), client.floor()});
    }
    for (const auto& association : in.associations()) {
        const auto via = from_proto(association.via());
        const auto from = from_proto(association.from());
        if (!via || !from) return std::nullopt;
        const Bytes keys = as_octets(association.keys());
        out.associations.push_back({.id = association.id(),
                                    .client = association.client(),
                                    .via = *via,
                                    .from = *from,
                                    .keys = {keys.begin(), keys.end()},
                                    .turn = association.turn(),
                                    .floor = association.floor()});
        if (!association.has_roaming_id()) continue;
        const auto at = from_proto(association.roaming_at());
        if (!at) return std::nullopt;
        const Bytes id = as_octets(association.roaming_id());
        out.associations.back().roaming.emplace(
            cluster::AssociationOfClient::Roaming{{id.begin(), id.end()}, *at});
    }
    for (const auto& progress : in.progress()) {
        out.progress.push_back(
            {progress.id(), progress.turn(), progress.floor(), progress.closed()});
    }
    return out;
}

}  // namespace

void to_proto(const cluster::ClusterMessage& in, ClusterMessage& out) {
    std::visit(MessageWriter{out}, in);
}

MaybeMessage from_proto(const ClusterMessage& in) {
    switch (in.message_case()) {
        case ClusterMessage::kHeartbeat:
            return read_heartbeat(in.heartbeat());
        case ClusterMessage::kParticulars:
            return read_particulars(in.particulars());
        case ClusterMessage::kLogBatch:
            return read_log_batch(in.log_batch());
        case ClusterMessage::kLogAck:
            return read_log_ack(in.log_ack());
        case ClusterMessage::kForwardBatch:
            return read_forward_batch(in.forward_batch());
        case ClusterMessage::kBallot:
            return read_ballot(in.ballot());
        case ClusterMessage::kViewProposal:
            return read_view_proposal(in.view_proposal());
        case ClusterMessage::kViewHoldings:
            return read_view_holdings(in.view_holdings());
        case ClusterMessage::kViewAnnouncement:
            return read_view_announcement(in.view_announcement());
        case ClusterMessage::kFetch:
            if (const auto after = from_proto(in.fetch().after())) {
                return cluster::Fetch{*after, broker::BrokerId{in.fetch().to()}};
            }
            break;
        case ClusterMessage::kSnapshotPart:
            return read_snapshot_part(in.snapshot_part());
        case ClusterMessage::kSessionRequest:
            if (const auto at = from_proto(in.session_request().at())) {
                return cluster::SessionRequest{in.session_request().client_id(), *at};
            }
            break;
        case ClusterMessage::kPulse:
            if (const auto log = from_proto(in.pulse().log())) {
                return cluster::Pulse{*log, in.pulse().tick()};
            }
            break;
        case ClusterMessage::kSecuredTold:
            return read_secured_told(in.secured_told());
        case ClusterMessage::MESSAGE_NOT_SET:
            break;
    }
    return std::nullopt;
}

}  // namespace romano::overlay::proto
