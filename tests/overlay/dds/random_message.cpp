#include "tests/overlay/dds/random_message.h"

#include <set>
#include <utility>

namespace romano::dds {
namespace {

std::uint64_t wide(Random& r) {
    return (std::uint64_t{r.next()} << 32U) | r.next();
}
/// A number that is one more than the one before it.
std::uint64_t counted(Random& r) {
    return wide(r) >> 2U;
}
bool flag(Random& r) {
    return r.below(2) == 1;
}

std::string text(Random& r, std::uint32_t most = 40) {
    std::string out(r.below(most + 1), '\0');
    for (char& c : out) c = static_cast<char>(r.below(256));
    return out;
}

std::vector<std::uint8_t> octets(Random& r) {
    const std::string from = text(r, 200);
    return {from.begin(), from.end()};
}

template <typename Make>
auto some(Random& r, Make make, std::uint32_t most = 4) {
    std::vector<decltype(make(r))> out;
    for (std::uint32_t n = r.below(most + 1); n > 0; --n) out.push_back(make(r));
    return out;
}

template <typename Enum>
Enum up_to(Random& r, Enum last) {
    return static_cast<Enum>(r.below(static_cast<std::uint32_t>(last) + 1));
}

mqttsn::Qos qos(Random& r) {
    return up_to(r, mqttsn::Qos::exactly_once);
}
mqttsn::MsgId msg_id(Random& r) {
    return static_cast<mqttsn::MsgId>(r.below(0x10000));
}
mqttsn::TopicId topic_id(Random& r) {
    return static_cast<mqttsn::TopicId>(r.below(0x10000));
}
broker::BrokerId broker_id(Random& r) {
    return broker::BrokerId{wide(r)};
}
broker::LogId log_id(Random& r) {
    return {broker_id(r), wide(r)};
}
broker::LogPosition position(Random& r) {
    return {log_id(r), wide(r)};
}

Endpoint endpoint(Random& r) {
    Endpoint out;
    out.family = up_to(r, Endpoint::Family::ipv6);
    if (out.family == Endpoint::Family::none) return out;
    const std::size_t size = out.family == Endpoint::Family::ipv4 ? 4 : 16;
    for (std::size_t i = 0; i < size; ++i) {
        out.address[i] = static_cast<std::uint8_t>(r.below(256));
    }
    out.port = static_cast<std::uint16_t>(r.below(0x10000));
    out.scope = r.below(4);
    out.packets = up_to(r, Endpoint::Packets::dtls);
    return out;
}

cluster::PacketsOfClient packets_of_client(Random& r) {
    return {wide(r), r.next(), r.next()};
}

cluster::AssociationOfClient association_of_client(Random& r) {
    cluster::AssociationOfClient out{wide(r),   text(r),  endpoint(r), endpoint(r),
                                     octets(r), r.next(), wide(r),     {}};
    if (flag(r)) out.roaming = {octets(r), endpoint(r)};
    return out;
}

cluster::ProgressOfAssociation progress_of_association(Random& r) {
    return {wide(r), r.next(), wide(r), flag(r)};
}

broker::MessagePtr message(Random& r) {
    return broker::MessagePtr{
        broker::Message{text(r), octets(r), qos(r), flag(r), position(r), {wide(r)}, text(r)}};
}

broker::SessionHeader header(Random& r) {
    return {text(r),
            {endpoint(r), text(r, 8)},
            endpoint(r),
            up_to(r, broker::SessionState::lost),
            flag(r),
            static_cast<std::uint16_t>(r.below(0x10000)),
            static_cast<std::uint16_t>(r.below(0x10000)),
            wide(r),
            flag(r),
            {wide(r)},
            {wide(r)},
            {wide(r)}};
}

broker::Will will(Random& r) {
    return {text(r), octets(r), qos(r), flag(r)};
}

broker::Subscription subscription(Random& r) {
    return {text(r), up_to(r, mqttsn::TopicIdType::short_name), topic_id(r), qos(r)};
}

broker::TopicBinding binding(Random& r) {
    return {topic_id(r), text(r), flag(r)};
}

broker::Delivery delivery(Random& r) {
    return {position(r), flag(r) ? message(r) : broker::MessagePtr{}, qos(r),
            flag(r),     up_to(r, broker::DeliveryStage::released),   msg_id(r)};
}

broker::SessionImage image(Random& r) {
    return {header(r),
            flag(r) ? std::optional(will(r)) : std::nullopt,
            some(r, subscription),
            some(r, binding),
            some(r, delivery),
            some(r, msg_id),
            some(r, position),
            msg_id(r)};
}

cluster::MovedSession moved_session(Random& r) {
    return {image(r), log_id(r), wide(r)};
}

broker::Route route(Random& r) {
    return {text(r), qos(r), flag(r)};
}

broker::LogEvent event_of(std::size_t kind, Random& r) {
    switch (kind) {
        case 0:
            if (flag(r)) return broker::SessionPut{image(r), position(r)};
            return broker::SessionPut{image(r)};
        case 1:
            return broker::SessionChanged{header(r), flag(r)};
        case 2:
            return broker::SessionErased{text(r)};
        case 3:
            return broker::WillChanged{text(r), flag(r) ? std::optional(will(r)) : std::nullopt};
        case 4:
            return broker::Subscribed{text(r), subscription(r)};
        case 5:
            return broker::Unsubscribed{text(r), text(r)};
        case 6:
            return broker::TopicBound{text(r), binding(r)};
        case 7:
            return broker::Published{message(r), text(r), msg_id(r), some(r, route), text(r)};
        case 8:
            return broker::Routed{position(r), some(r, route)};
        case 9:
            return broker::Cursor{some(r, position)};
        case 10:
            return broker::DeliveryStarted{text(r), position(r), msg_id(r), qos(r)};
        case 11:
            return broker::DeliveryReleased{text(r), position(r)};
        case 12:
            return broker::DeliveryEnded{text(r), position(r)};
        case 13:
            return broker::PublishReleased{text(r), msg_id(r)};
        case 14:
            return broker::SessionMoved{header(r), log_id(r)};
        default:
            return broker::Sealed{endpoint(r), log_id(r)};
    }
}
static_assert(std::variant_size_v<broker::LogEvent> == 16, "event_of() makes every kind");

std::vector<broker::LogEventPtr> one_event_of_each_kind(Random& r) {
    std::vector<broker::LogEventPtr> out;
    for (std::size_t kind = 0; kind < std::variant_size_v<broker::LogEvent>; ++kind) {
        out.push_back(event_of(kind, r));
    }
    return out;
}

cluster::ViewNumber view_number(Random& r) {
    return {counted(r), broker_id(r), counted(r)};
}
cluster::View view(Random& r) {
    const auto members = some(r, log_id);
    const std::set<broker::LogId> sorted(members.begin(), members.end());
    return {view_number(r), {sorted.begin(), sorted.end()}};
}

election::Claim claim(Random& r) {
    election::Claim out{{r.next(), r.next(), election::NodeId{wide(r)}}, counted(r), std::nullopt};
    if (flag(r)) out.leader = election::NodeId{wide(r)};
    return out;
}

cluster::LeftAddress left_address(Random& r) {
    return {log_id(r), endpoint(r)};
}
cluster::Assignment assignment(Random& r) {
    return {position(r), endpoint(r), broker_id(r)};
}

cluster::Setting setting(Random& r) {
    return {text(r), text(r), r.next()};
}

cluster::Beacon beacon(Random& r) {
    cluster::Beacon out;
    out.name = text(r);
    out.log = {broker::broker_id_of(out.name), wide(r)};
    out.last_seq = wide(r);
    out.tick = wide(r);
    out.view = view(r);
    out.promised = view_number(r);
    out.claim = claim(r);
    out.hears = some(r, broker_id);
    for (const auto& [of, tick] : some(r, position)) out.echoes.push_back({of, tick});
    out.vouched = some(r, broker_id);
    out.applied = some(r, position);
    out.ended = some(r, position);
    out.home_addresses = some(r, endpoint);
    out.serving = some(r, endpoint);
    out.binding = some(r, endpoint);
    out.sessions = r.next();
    out.connected = r.next();
    out.cannot_take = r.next();
    out.usage = {wide(r), wide(r), r.next(), r.next()};
    out.leaving = flag(r);
    out.link = {endpoint(r), wide(r)};
    for (auto& octet : out.link.secret) octet = static_cast<std::uint8_t>(r.next());
    out.settings = r.next();
    out.predefined = r.next();
    return out;
}

cluster::HeldByMember held(Random& r) {
    return {r.next(), wide(r)};
}

cluster::Heartbeat heartbeat(Random& r) {
    cluster::Heartbeat out;
    out.log = log_id(r);
    out.tick = wide(r);
    out.last_seq = wide(r);
    out.particulars = r.next();
    out.view = view_number(r);
    out.promised = view_number(r);
    out.claim = claim(r);
    out.members = r.next();
    out.hears_members = octets(r);
    out.echoes = octets(r);
    out.hears_others = some(r, broker_id);
    out.held = some(r, held);
    out.held_others = some(r, position);
    out.logs_held = r.next();
    out.sessions = r.next();
    out.connected = r.next();
    out.usage = {wide(r), wide(r), r.next(), r.next()};
    out.leaving = flag(r);
    return out;
}

}  // namespace

cluster::ClusterMessage random_message(std::size_t kind, Random& r) {
    switch (kind) {
        case 0:
            return heartbeat(r);
        case 1:
            return cluster::LogBatch{log_id(r), wide(r), one_event_of_each_kind(r), flag(r)};
        case 2:
            return cluster::LogAck{position(r), log_id(r)};
        case 3:
            return cluster::ForwardBatch{some(r, message)};
        case 4:
            return cluster::ElectionMessage{{static_cast<std::uint8_t>(r.below(256)), counted(r)}};
        case 5:
            return cluster::ViewProposal{view(r), some(r, log_id)};
        case 6:
            return cluster::ViewHoldings{view_number(r),        some(r, position), some(r, log_id),
                                         some(r, left_address), some(r, position), some(r, log_id),
                                         some(r, endpoint)};
        case 7:
            return cluster::ViewAnnouncement{view(r), some(r, assignment), some(r, position)};
        case 8:
            return cluster::Fetch{position(r), broker_id(r)};
        case 9:
            return cluster::SnapshotPart{
                position(r),       wide(r),
                r.next(),          flag(r),
                some(r, image),    some(r, [](Random& from) { return text(from); }),
                some(r, message),  some(r, message),
                some(r, position), some(r, moved_session)};
        case 10:
            return cluster::SessionRequest{text(r), endpoint(r)};
        case 11:
            return cluster::Pulse{log_id(r), wide(r)};
        case 12:
            return cluster::Particulars{beacon(r), some(r, setting)};
        default:
            return cluster::SecuredTold{some(r, packets_of_client), some(r, association_of_client),
                                        some(r, progress_of_association)};
    }
}
static_assert(message_kinds == 14, "random_message() makes every kind");

}  // namespace romano::dds
