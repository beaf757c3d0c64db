#include "overlay/dds/log_event_proto.h"

#include "overlay/dds/session_proto.h"

namespace romano::overlay::proto {
namespace {

using MaybeEvent = std::optional<broker::LogEvent>;

void to_proto(const broker::Route& in, Route& out) {
    out.set_client_id(in.client_id);
    out.set_qos(static_cast<std::uint32_t>(in.qos));
    out.set_retain(in.retain);
}

std::optional<broker::Route> from_proto(const Route& in) {
    const auto qos = qos_from(in.qos());
    if (!qos) return std::nullopt;
    return broker::Route{in.client_id(), *qos, in.retain()};
}

// One overload an event: writes it as the alternative of the oneof that is its own.
struct EventWriter {
    LogEvent& out;

    void operator()(const broker::SessionPut& e) const {
        if (!e.adopted) return to_proto(e.image, *out.mutable_session_put());
        auto& to = *out.mutable_session_adopted();
        to_proto(e.image, *to.mutable_image());
        to_proto(*e.adopted, *to.mutable_moved());
    }
    void operator()(const broker::SessionMoved& e) const {
        auto& to = *out.mutable_session_moved();
        to_proto(e.header, *to.mutable_header());
        to_proto(e.to, *to.mutable_to());
    }
    void operator()(const broker::Sealed& e) const {
        auto& to = *out.mutable_sealed();
        to_proto(e.address, *to.mutable_address());
        to_proto(e.to, *to.mutable_to());
    }
    void operator()(const broker::SessionChanged& e) const {
        auto& to = *out.mutable_session_changed();
        to_proto(e.header, *to.mutable_header());
        to.set_forgets_topics(e.forgets_topics);
    }
    void operator()(const broker::SessionErased& e) const { out.set_session_erased(e.client_id); }
    void operator()(const broker::WillChanged& e) const {
        auto& to = *out.mutable_will_changed();
        to.set_client_id(e.client_id);
        if (e.will) to_proto(*e.will, *to.mutable_will());
    }
    void operator()(const broker::Subscribed& e) const {
        auto& to = *out.mutable_subscribed();
        to.set_client_id(e.client_id);
        to_proto(e.subscription, *to.mutable_subscription());
    }
    void operator()(const broker::Unsubscribed& e) const {
        auto& to = *out.mutable_unsubscribed();
        to.set_client_id(e.client_id);
        to.set_filter(e.filter);
    }
    void operator()(const broker::TopicBound& e) const {
        auto& to = *out.mutable_topic_bound();
        to.set_client_id(e.client_id);
        to_proto(e.binding, *to.mutable_binding());
    }
    void operator()(const broker::Published& e) const {
        auto& to = *out.mutable_published();
        to_proto(e.message, *to.mutable_message());
        to.set_publisher(e.publisher);
        to.set_msg_id(static_cast<std::uint32_t>(e.msg_id));
        for (const auto& route : e.routes) to_proto(route, *to.add_routes());
        to.set_will_of(e.will_of);
    }
    void operator()(const broker::Routed& e) const {
        auto& to = *out.mutable_routed();
        to_proto(e.message, *to.mutable_message());
        for (const auto& route : e.routes) to_proto(route, *to.add_routes());
    }
    void operator()(const broker::Cursor& e) const {
        auto& to = *out.mutable_cursor();
        for (const broker::LogPosition& position : e.through) {
            to.add_brokers(static_cast<std::uint64_t>(position.log.broker));
            to.add_incarnations(position.log.incarnation);
            to.add_through(position.seq);
        }
    }
    void operator()(const broker::DeliveryStarted& e) const {
        auto& to = *out.mutable_delivery_started();
        to.set_client_id(e.client_id);
        to_proto(e.message, *to.mutable_message());
        to.set_msg_id(static_cast<std::uint32_t>(e.msg_id));
        to.set_qos(static_cast<std::uint32_t>(e.qos));
    }
    void operator()(const broker::DeliveryReleased& e) const {
        step(e.client_id, e.message, *out.mutable_delivery_released());
    }
    void operator()(const broker::DeliveryEnded& e) const {
        step(e.client_id, e.message, *out.mutable_delivery_ended());
    }
    void operator()(const broker::PublishReleased& e) const {
        auto& to = *out.mutable_publish_released();
        to.set_client_id(e.client_id);
        to.set_msg_id(static_cast<std::uint32_t>(e.msg_id));
    }

    static void step(const broker::ClientId& client_id, const broker::LogPosition& message,
                     DeliveryStep& to) {
        to.set_client_id(client_id);
        to_proto(message, *to.mutable_message());
    }
};

template <typename Routes>
bool read_routes(const Routes& in, std::vector<broker::Route>& out) {
    for (const auto& item : in) {
        auto route = from_proto(item);
        if (!route) return false;
        out.push_back(std::move(*route));
    }
    return true;
}

MaybeEvent read_will_changed(const WillChanged& in) {
    broker::WillChanged out{in.client_id(), std::nullopt};
    if (in.has_will()) {
        out.will = from_proto(in.will());
        if (!out.will) return std::nullopt;
    }
    return out;
}

MaybeEvent read_published(const Published& in) {
    auto message = from_proto(in.message());
    const auto msg_id = narrow<mqttsn::MsgId>(in.msg_id());
    if (!in.has_message() || !message || !msg_id) return std::nullopt;
    broker::Published out{std::move(*message), in.publisher(), *msg_id, {}, in.will_of()};
    if (!read_routes(in.routes(), out.routes)) return std::nullopt;
    return out;
}

MaybeEvent read_routed(const Routed& in) {
    const auto message = from_proto(in.message());
    if (!message) return std::nullopt;
    broker::Routed out{*message, {}};
    if (!read_routes(in.routes(), out.routes)) return std::nullopt;
    return out;
}

MaybeEvent read_delivery_started(const DeliveryStarted& in) {
    const auto message = from_proto(in.message());
    const auto msg_id = narrow<mqttsn::MsgId>(in.msg_id());
    const auto qos = qos_from(in.qos());
    if (!message || !msg_id || !qos) return std::nullopt;
    return broker::DeliveryStarted{in.client_id(), *message, *msg_id, *qos};
}

template <typename Step>
MaybeEvent read_step(const DeliveryStep& in) {
    const auto message = from_proto(in.message());
    if (!message) return std::nullopt;
    return Step{in.client_id(), *message};
}

MaybeEvent read_session_adopted(const SessionAdopted& in) {
    auto image = from_proto(in.image());
    const auto moved = from_proto(in.moved());
    if (!image || !moved) return std::nullopt;
    return broker::SessionPut{std::move(*image), *moved};
}

MaybeEvent read_session_moved(const SessionMoved& in) {
    auto header = from_proto(in.header());
    const auto to = from_proto(in.to());
    if (!header || !to) return std::nullopt;
    return broker::SessionMoved{std::move(*header), *to};
}

MaybeEvent read_cursor(const Cursor& in) {
    const int count = in.brokers_size();
    if (in.incarnations_size() != count || in.through_size() != count) return std::nullopt;
    broker::Cursor out;
    out.through.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
        out.through.push_back(
            {{broker::BrokerId{in.brokers(i)}, in.incarnations(i)}, in.through(i)});
    }
    return out;
}

MaybeEvent read_sealed(const Sealed& in) {
    const auto address = from_proto(in.address());
    const auto to = from_proto(in.to());
    if (!address || !to) return std::nullopt;
    return broker::Sealed{*address, *to};
}

}  // namespace

void to_proto(const broker::LogEventPtr& in, LogEvent& out) {
    std::visit(EventWriter{out}, *in);
}

MaybeEvent from_proto(const LogEvent& in) {
    switch (in.event_case()) {
        case LogEvent::kSessionPut:
            if (auto image = from_proto(in.session_put())) {
                return broker::SessionPut{std::move(*image)};
            }
            break;
        case LogEvent::kSessionChanged:
            if (auto header = from_proto(in.session_changed().header())) {
                return broker::SessionChanged{std::move(*header),
                                              in.session_changed().forgets_topics()};
            }
            break;
        case LogEvent::kSessionErased:
            return broker::SessionErased{in.session_erased()};
        case LogEvent::kWillChanged:
            return read_will_changed(in.will_changed());
        case LogEvent::kSubscribed:
            if (auto subscription = from_proto(in.subscribed().subscription())) {
                return broker::Subscribed{in.subscribed().client_id(), std::move(*subscription)};
            }
            break;
        case LogEvent::kUnsubscribed:
            return broker::Unsubscribed{in.unsubscribed().client_id(), in.unsubscribed().filter()};
        case LogEvent::kTopicBound:
            if (auto binding = from_proto(in.topic_bound().binding())) {
                return broker::TopicBound{in.topic_bound().client_id(), std::move(*binding)};
            }
            break;
        case LogEvent::kPublished:
            return read_published(in.published());
        case LogEvent::kRouted:
            return read_routed(in.routed());
        case LogEvent::kCursor:
            return read_cursor(in.cursor());
        case LogEvent::kDeliveryStarted:
            return read_delivery_started(in.delivery_started());
        case LogEvent::kDeliveryReleased:
            return read_step<broker::DeliveryReleased>(in.delivery_released());
        case LogEvent::kDeliveryEnded:
            return read_step<broker::DeliveryEnded>(in.delivery_ended());
        case LogEvent::kPublishReleased:
            if (const auto msg_id = narrow<mqttsn::MsgId>(in.publish_released().msg_id())) {
                return broker::PublishReleased{in.publish_released().client_id(), *msg_id};
            }
            break;
        case LogEvent::kSessionAdopted:
            return read_session_adopted(in.session_adopted());
        case LogEvent::kSessionMoved:
            return read_session_moved(in.session_moved());
        case LogEvent::kSealed:
            return read_sealed(in.sealed());
        case LogEvent::EVENT_NOT_SET:
            break;
    }
    return std::nullopt;
}

}  // namespace romano::overlay::proto
