#include "overlay/member/carried_uplink.h"

#include <algorithm>
#include <utility>

#include "romano/base/printable.h"
#include "romano/mqttsn/codec.h"

namespace romano::overlay {
namespace {

using Datagrams = std::vector<std::vector<std::uint8_t>>;

std::vector<std::uint8_t> encoded(const mqttsn::Message& message) {
    std::vector<std::uint8_t> octets(512);
    octets.resize(mqttsn::encode(message, octets));
    return octets;
}

mqttsn::TopicRef by_name(const std::string& filter) {
    return {.type = mqttsn::TopicIdType::normal, .name = filter, .id = mqttsn::no_topic_id};
}

}  // namespace

Datagrams CarriedUplink::requests(Instant now, const broker::BrokerCore& broker,
                                  const cluster::ClusterCore& cluster,
                                  std::vector<uplink::UplinkAction>& out) {
    if (std::exchange(view_, cluster.view().number) != cluster.view().number) view_since_ = now;
    leads_ = cluster.is_in_view() && view_.leader == cluster.own_log().id().broker;
    const broker::SessionHeader* header = broker.header(client_id_);
    const bool is_here = header != nullptr && header->state == broker::SessionState::active &&
                         !header->provisional && header->address.endpoint == broker::owner_endpoint;
    if (!leads_) {
        is_subscribed_ = false;
        // What was taken goes out first: the next leader does not have it.
        if (taken_.empty() || now >= led_at_ + cluster.times().taken_safe_within()) let_go(out);
        return {};
    }
    led_at_ = now;
    if (!is_here) {
        is_subscribed_ = false;
        subscribe_again_at_ = Instant::min();
        if (!may_connect(now, broker, cluster)) return {};
        connect_again_at_ = now + cluster.times().uplink_session_asked_again_after();
        return {encoded(mqttsn::Connect{.will = false,
                                        .clean_session = false,
                                        .protocol_id = mqttsn::protocol_id,
                                        .duration_s = 0,
                                        .client_id = client_id_})};
    }
    if (!is_subscribed_) {
        Datagrams missing = missing_subscriptions(broker);
        is_subscribed_ = missing.empty();
        if (now < subscribe_again_at_) missing.clear();
        if (!missing.empty()) {
            subscribe_again_at_ = now + cluster.times().uplink_session_asked_again_after();
        }
        if (!is_subscribed_) return missing;
    }
    core_.hold(true, out);  // not before: what is published from then on goes out
    return {};
}

bool CarriedUplink::may_connect(Instant now, const broker::BrokerCore& broker,
                                const cluster::ClusterCore& cluster) {
    if (now < connect_again_at_) return false;
    return broker.header(client_id_) != nullptr || cluster.is_homed_at_peer(client_id_) ||
           now >= view_since_ + cluster.times().uplink_session_found_within();
}

Datagrams CarriedUplink::missing_subscriptions(const broker::BrokerCore& broker) const {
    const auto image = broker.image(client_id_);
    const auto wanted = core_.rules().local_filters();
    Datagrams out;
    std::uint16_t msg_id = 0;
    for (const uplink::Filter& filter : wanted) {
        const auto has = [&](const broker::Subscription& subscription) {
            return subscription.filter == filter.filter && subscription.granted == filter.qos;
        };
        if (std::ranges::any_of(image->subscriptions, has)) continue;
        out.push_back(encoded(mqttsn::Subscribe{.dup = false,
                                                .qos = filter.qos,
                                                .msg_id = mqttsn::MsgId{++msg_id},
                                                .topic = by_name(filter.filter)}));
    }
    for (const broker::Subscription& subscription : image->subscriptions) {
        if (std::ranges::count(wanted, subscription.filter, &uplink::Filter::filter) != 0) continue;
        out.push_back(encoded(mqttsn::Unsubscribe{.msg_id = mqttsn::MsgId{++msg_id},
                                                  .topic = by_name(subscription.filter)}));
    }
    return out;
}

void CarriedUplink::on_answer(Instant now, const broker::LogPosition& position,
                              uplink::Answer answer, broker::BrokerCore& broker,
                              broker::Actions& actions) {
    core_.on_answer(position, answer);
    if (answer != uplink::Answer::done) return;
    broker.on_read(now, position, actions);
    confirmed_ = broker.last_seq();
}

void CarriedUplink::on_message(Instant now, const cluster::Times& times,
                               const uplink::FromRemote& message, std::uint64_t token,
                               broker::BrokerCore& broker, broker::Actions& actions,
                               std::vector<cluster::LocalAction>& local) {
    const std::size_t most = broker.limits().payload_octets;
    if (message.payload.size() > most) {
        warn_of_long(now, times, message, most, local);
    } else if (const auto inbound = core_.receive(message)) {
        broker.publish(now, inbound->place.topic, message.payload, inbound->place.qos,
                       message.retain, actions, inbound->origin);
        core_.remember(inbound->origin);
    }
    // A repetition too: what it repeats may not be safe yet.
    if (token != 0) unsafe_[broker.last_seq()].push_back(token);
}

/// MQTT allows 256 MB, an MQTT-SN datagram holds less than 64 KiB.
void CarriedUplink::warn_of_long(Instant now, const cluster::Times& times,
                                 const uplink::FromRemote& message, std::size_t most,
                                 std::vector<cluster::LocalAction>& local) {
    ++too_long_;
    if (now < warn_again_at_) return;
    warn_again_at_ = now + times.long_message_told_every();
    local.push_back(cluster::Notice{"the message of " + std::to_string(message.payload.size()) +
                                        " octets that came for '" + printable(message.topic) +
                                        "' is dropped: MQTT-SN clients can be sent " +
                                        std::to_string(most) + " (max-payload-octets); " +
                                        std::to_string(too_long_) + " so far",
                                    true});
}

void CarriedUplink::on_for_owner(const broker::MessagePtr& message,
                                 std::vector<uplink::UplinkAction>& out) {
    if (message->origin.empty()) {
        core_.send_now(message, out);
    } else {
        core_.remember(message->origin);
    }
}

void CarriedUplink::go_on(Instant now, const broker::LogPosition& own, broker::BrokerCore& broker,
                          broker::Actions& actions, std::vector<uplink::UplinkAction>& out) {
    while (!unsafe_.empty() && unsafe_.begin()->first <= own.seq) {
        for (const std::uint64_t token : unsafe_.begin()->second) {
            out.emplace_back(uplink::Acknowledge{token});
        }
        unsafe_.erase(unsafe_.begin());
    }
    while (!taken_.empty() && taken_.front().first <= own.seq) {
        out.emplace_back(std::move(taken_.front().second));
        taken_.pop_front();
    }
    if (!leads_ || !core_.is_up()) return;
    const std::size_t before = out.size();
    core_.send(broker.unread(), own, out);
    if (takes_before_sending_) take(now, before, broker, actions, out);
    for (std::size_t i = before; i < out.size(); ++i) {
        const auto* discard = std::get_if<uplink::Discard>(&out[i]);
        if (discard != nullptr) broker.on_read(now, discard->position, actions);
    }
}

void CarriedUplink::take(Instant now, std::size_t first, broker::BrokerCore& broker,
                         broker::Actions& actions, std::vector<uplink::UplinkAction>& out) {
    const auto is_taken = [&](uplink::UplinkAction& action) {
        auto* message = std::get_if<uplink::PublishUp>(&action);
        if (message == nullptr || message->qos != mqttsn::Qos::exactly_once) return false;
        broker.on_read(now, message->message->position, actions);
        confirmed_ = broker.last_seq();
        taken_.emplace_back(confirmed_, std::move(*message));
        return true;
    };
    const auto rest = out.begin() + static_cast<std::ptrdiff_t>(first);
    out.erase(std::remove_if(rest, out.end(), is_taken), out.end());
}

}  // namespace romano::overlay
