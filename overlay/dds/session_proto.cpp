#include "overlay/dds/session_proto.h"

namespace romano::overlay::proto {

std::optional<mqttsn::Qos> qos_from(std::uint32_t value) {
    return enum_from(value, mqttsn::Qos::exactly_once);
}

void to_proto(const broker::MessagePtr& in, Message& out) {
    out.set_topic(in->topic);
    out.set_payload(in->payload.data(), in->payload.size());
    out.set_qos(static_cast<std::uint32_t>(in->qos));
    out.set_retain(in->retain);
    to_proto(in->position, *out.mutable_position());
    out.set_published_at(in->published_at.value);
    if (!in->origin.empty()) out.set_origin(in->origin);
}

std::optional<broker::MessagePtr> from_proto(const Message& in) {
    const auto qos = qos_from(in.qos());
    const auto position = from_proto(in.position());
    if (!qos || !position) return std::nullopt;
    return broker::MessagePtr{broker::Message{.topic = in.topic(),
                                              .payload = octets_of(in.payload()),
                                              .qos = *qos,
                                              .retain = in.retain(),
                                              .position = *position,
                                              .published_at = {in.published_at()},
                                              .origin = in.origin()}};
}

void to_proto(const broker::SessionHeader& in, SessionHeader& out) {
    out.set_client_id(in.client_id);
    to_proto(in.address.endpoint, *out.mutable_address()->mutable_endpoint());
    out.mutable_address()->set_wireless_node_id(in.address.wireless_node_id);
    to_proto(in.via, *out.mutable_via());
    out.set_state(static_cast<std::uint32_t>(in.state));
    out.set_clean(in.clean);
    out.set_keep_alive_s(in.keep_alive_s);
    out.set_sleep_s(in.sleep_s);
    out.set_epoch(in.epoch);
    out.set_provisional(in.provisional);
    out.set_last_heard(in.last_heard.value);
    out.set_departed(in.departed.value);
    out.set_last_published(in.last_published.value);
}

std::optional<broker::SessionHeader> from_proto(const SessionHeader& in) {
    const auto endpoint = from_proto(in.address().endpoint());
    const auto via = from_proto(in.via());
    const auto state = enum_from(in.state(), broker::SessionState::lost);
    const auto keep_alive = narrow<std::uint16_t>(in.keep_alive_s());
    const auto sleep = narrow<std::uint16_t>(in.sleep_s());
    if (!endpoint || !via || !state || !keep_alive || !sleep) return std::nullopt;
    return broker::SessionHeader{.client_id = in.client_id(),
                                 .address = {*endpoint, in.address().wireless_node_id()},
                                 .via = *via,
                                 .state = *state,
                                 .clean = in.clean(),
                                 .keep_alive_s = *keep_alive,
                                 .sleep_s = *sleep,
                                 .epoch = in.epoch(),
                                 .provisional = in.provisional(),
                                 .last_heard = {in.last_heard()},
                                 .departed = {in.departed()},
                                 .last_published = {in.last_published()}};
}

void to_proto(const broker::Will& in, Will& out) {
    out.set_topic(in.topic);
    out.set_message(in.message.data(), in.message.size());
    out.set_qos(static_cast<std::uint32_t>(in.qos));
    out.set_retain(in.retain);
}

std::optional<broker::Will> from_proto(const Will& in) {
    const auto qos = qos_from(in.qos());
    if (!qos) return std::nullopt;
    return broker::Will{in.topic(), octets_of(in.message()), *qos, in.retain()};
}

void to_proto(const broker::Subscription& in, Subscription& out) {
    out.set_filter(in.filter);
    out.set_type(static_cast<std::uint32_t>(in.type));
    out.set_predefined_id(static_cast<std::uint32_t>(in.predefined_id));
    out.set_granted(static_cast<std::uint32_t>(in.granted));
}

std::optional<broker::Subscription> from_proto(const Subscription& in) {
    const auto type = enum_from(in.type(), mqttsn::TopicIdType::short_name);
    const auto predefined = narrow<mqttsn::TopicId>(in.predefined_id());
    const auto granted = qos_from(in.granted());
    if (!type || !predefined || !granted) return std::nullopt;
    return broker::Subscription{in.filter(), *type, *predefined, *granted};
}

void to_proto(const broker::TopicBinding& in, TopicBinding& out) {
    out.set_id(static_cast<std::uint32_t>(in.id));
    out.set_name(in.name);
    out.set_known_to_client(in.known_to_client);
}

std::optional<broker::TopicBinding> from_proto(const TopicBinding& in) {
    const auto id = narrow<mqttsn::TopicId>(in.id());
    if (!id) return std::nullopt;
    return broker::TopicBinding{*id, in.name(), in.known_to_client()};
}

void to_proto(const broker::Delivery& in, Delivery& out) {
    to_proto(in.position, *out.mutable_position());
    if (in.message) to_proto(in.message, *out.mutable_message());
    out.set_qos(static_cast<std::uint32_t>(in.qos));
    out.set_retain(in.retain);
    out.set_stage(static_cast<std::uint32_t>(in.stage));
    out.set_msg_id(static_cast<std::uint32_t>(in.msg_id));
}

std::optional<broker::Delivery> from_proto(const Delivery& in) {
    const auto position = from_proto(in.position());
    const auto qos = qos_from(in.qos());
    const auto stage = enum_from(in.stage(), broker::DeliveryStage::released);
    const auto msg_id = narrow<mqttsn::MsgId>(in.msg_id());
    if (!position || !qos || !stage || !msg_id) return std::nullopt;
    broker::MessagePtr message;
    if (in.has_message()) {
        auto held = from_proto(in.message());
        if (!held) return std::nullopt;
        message = std::move(*held);
    }
    return broker::Delivery{*position, std::move(message), *qos, in.retain(), *stage, *msg_id};
}

void to_proto(const broker::SessionImage& in, SessionImage& out) {
    to_proto(in.header, *out.mutable_header());
    if (in.will) to_proto(*in.will, *out.mutable_will());
    all_to_proto(in.subscriptions, *out.mutable_subscriptions());
    all_to_proto(in.topics, *out.mutable_topics());
    all_to_proto(in.deliveries, *out.mutable_deliveries());
    for (const mqttsn::MsgId id : in.unreleased) {
        out.add_unreleased(static_cast<std::uint32_t>(id));
    }
    all_to_proto(in.worked_through, *out.mutable_worked_through());
    out.set_last_msg_id(static_cast<std::uint32_t>(in.last_msg_id));
}

std::optional<broker::SessionImage> from_proto(const SessionImage& in) {
    broker::SessionImage out;
    auto header = from_proto(in.header());
    if (!header) return std::nullopt;
    out.header = std::move(*header);
    if (in.has_will()) {
        out.will = from_proto(in.will());
        if (!out.will) return std::nullopt;
    }
    if (!all_from_proto(in.subscriptions(), out.subscriptions)) return std::nullopt;
    if (!all_from_proto(in.topics(), out.topics)) return std::nullopt;
    if (!all_from_proto(in.deliveries(), out.deliveries)) return std::nullopt;
    for (const std::uint32_t value : in.unreleased()) {
        const auto id = narrow<mqttsn::MsgId>(value);
        if (!id) return std::nullopt;
        out.unreleased.push_back(*id);
    }
    if (!all_from_proto(in.worked_through(), out.worked_through)) return std::nullopt;
    const auto last_msg_id = narrow<mqttsn::MsgId>(in.last_msg_id());
    if (!last_msg_id) return std::nullopt;
    out.last_msg_id = *last_msg_id;
    return out;
}

}  // namespace romano::overlay::proto
