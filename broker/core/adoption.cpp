#include "broker/core/adoption.h"

#include <algorithm>
#include <utility>

#include "broker/core/session_deadline.h"
#include "broker/core/session_image_of.h"
#include "broker/core/two_copies.h"
#include "romano/mqttsn/topic.h"

namespace romano::broker {

using mqttsn::Qos;

namespace {

Qos granted_to(const SessionImage& image, const Message& message) {
    Qos most = Qos::at_most_once;
    for (const Subscription& subscription : image.subscriptions) {
        if (subscription.granted > most && mqttsn::matches(subscription.filter, message.topic)) {
            most = subscription.granted;
        }
    }
    return most;
}

/// The store of a lone broker has only those of open exchanges.
mqttsn::MsgId last_msg_id(const SessionImage& image) {
    mqttsn::MsgId last = image.last_msg_id;
    if (last != mqttsn::no_msg_id) return last;
    for (const Delivery& delivery : image.deliveries) {
        if (delivery.msg_id != mqttsn::no_msg_id) last = delivery.msg_id;
    }
    return last;
}

/// The msg ids go on where no other home has been lately: one that is cut off from us may speak to
/// the client as well, and a QoS 2 receiver takes a message for the one that it has not released
/// under the same id.
std::uint16_t far_from(mqttsn::MsgId one, mqttsn::MsgId other, Random& random) {
    constexpr std::uint32_t least = 0x1000;
    for (;;) {
        const std::uint32_t step = least + random.below(0x10000 - 2 * least);
        const auto id = static_cast<std::uint16_t>(static_cast<std::uint32_t>(one) + step);
        const auto ahead =
            static_cast<std::uint16_t>(std::uint32_t{id} - static_cast<std::uint32_t>(other));
        if (ahead >= least && ahead <= 0x10000 - least) return id;
    }
}

/// The rank of a home's copy does not fall when another one takes its place: other homes have
/// compared theirs with it, and would both give way (overlay/cluster/ownership/settlement.h).
void keep_rank(SessionHeader& comes, const SessionHeader& own) {
    if (comes.epoch == own.epoch) ++comes.epoch;
    comes.last_heard = std::max(comes.last_heard, own.last_heard);
}

}  // namespace

bool Adoption::adopt(SessionImage image, std::vector<MessagePtr> missed,
                     const std::optional<LogPosition>& moved, std::optional<SessionImage> ours,
                     Turn& turn) {
    tables_.clock.observe(image.header.last_heard);
    Session* session = tables_.sessions.find(image.header.client_id);
    Settled settled;
    if (session != nullptr) {
        settled = settle(image_of(*session, tables_), std::move(image), missed);
        if (settled.comes) keep_rank(settled.image.header, session->header);
        if (settled.is_new) {
            tables_.sessions.come_back(*session);
            tables_.sessions.unmap(*session);
            lifecycle_.wipe(*session);
        }
    } else {
        if (ours) {
            const SessionHeader own = ours->header;
            settled = settle(*std::move(ours), std::move(image), missed);
            if (settled.comes) keep_rank(settled.image.header, own);
            settled.is_new = true;
        } else {
            settled.image = std::move(image);
        }
        session = &tables_.sessions.create(settled.image.header.client_id);
        session->read_by_owner = settled.image.header.client_id == tables_.options.read_by_owner;
    }
    if (settled.is_new) {
        if (settled.comes) settled.image = caught_up(std::move(settled.image), missed);
        session->last_msg_id =
            far_from(last_msg_id(settled.image), settled.last_msg_id_elsewhere, tables_.random);
        restore(*session, settled.image, turn);
    }
    // Also when the own copy stays as it is: of the other one nothing is left for anybody else.
    tables_.log.append(turn.out, [&] { return SessionPut{bare_image_of(*session), moved}; });
    if (settled.is_new) schedule(tables_, *session);
    if (settled.unfinished != mqttsn::no_msg_id) session->unfinished = settled.unfinished;
    deliveries_.release_unfinished(*session, turn);
    if (settled.is_new) deliveries_.go_on(*session, turn);
    return settled.comes;
}

void Adoption::restore(Session& session, SessionImage& image, Turn& turn) {
    const Origin place{image.header.via, image.header.address};
    SessionHeader& header = session.header;
    // The client id stays where it is: tables hold views of it.
    header.via = place.via;
    header.address = place.from;
    header.state = image.header.state;
    header.clean = image.header.clean;
    header.keep_alive_s = image.header.keep_alive_s;
    header.sleep_s = image.header.sleep_s;
    header.epoch = image.header.epoch;
    header.provisional = image.header.provisional;
    header.last_heard = image.header.last_heard;
    header.departed = image.header.departed;
    header.last_published = image.header.last_published;

    session.will = std::move(image.will);
    session.subscriptions = std::move(image.subscriptions);
    session.topics.restore(image.topics);
    session.unreleased = std::move(image.unreleased);
    std::stable_partition(image.deliveries.begin(), image.deliveries.end(), [](const Delivery& d) {
        return d.stage != DeliveryStage::queued;  // the open exchange is about the front
    });
    for (Delivery& delivery : image.deliveries) restore(session, delivery);
    for (const LogPosition& position : image.worked_through) {
        const bool is_own = position.log == tables_.log.id();
        const Seq ours = is_own ? tables_.log.last() : tables_.cursors.at(position.log);
        if (position.seq > ours) session.worked_ahead.push_back(position);
    }
    subscriptions_.enter_all(session);

    session.heard_at = turn.now;  // keep-alive and sleep timers start again
    session.probe_at = never;
    session.fresh = session.fresh_will = false;
    if (!session.is_connected()) {
        const bool is_dated = header.departed != HybridTime{};
        const Duration ago =
            is_dated ? tables_.clock.since(header.departed, turn.now) : Duration{0};
        tables_.sessions.depart(session, turn.now - ago);
    }
    if (place.from.endpoint.family != Endpoint::Family::none) {
        lifecycle_.settle_at(session, place, turn);
    }
}

/// One exchange goes on, that of the front. What else may have been sent at QoS 2 goes out again
/// under its id, or, when the client has it or it cannot come, is released.
void Adoption::restore(Session& session, Delivery& delivery) {
    const bool is_open = delivery.stage != DeliveryStage::queued;
    const bool may_be_there = is_open && delivery.qos == Qos::exactly_once;
    const bool is_there = may_be_there && delivery.stage == DeliveryStage::released;
    const auto begin_anew = [&delivery] {
        delivery.stage = DeliveryStage::queued;
        delivery.msg_id = mqttsn::no_msg_id;
    };
    if (delivery.message && (!is_there || session.queue.empty())) {
        if (is_open && !session.queue.empty()) {
            if (may_be_there) session.begun.push_back({delivery.position, delivery.msg_id});
            begin_anew();
        }
        session.queue.push(std::move(delivery));
    } else if (!is_there && is_to_come(delivery.position)) {
        if (!may_be_there) begin_anew();
        session.awaited.push_back(std::move(delivery));
    } else if (may_be_there) {
        session.unfinished = delivery.msg_id;
    }
}

/// Its writer is out of our sight, and may be back with it.
bool Adoption::is_to_come(const LogPosition& position) const {
    return position.log != tables_.log.id() && position.seq > tables_.cursors.at(position.log);
}

SessionImage Adoption::caught_up(SessionImage image, std::span<const MessagePtr> missed) {
    for (const MessagePtr& message : missed) {
        const Qos qos = std::min(message->qos, granted_to(image, *message));
        if (qos == Qos::at_most_once || !keeps_messages(image.header)) continue;
        if (!message->origin.empty() && image.header.client_id == tables_.options.read_by_owner) {
            continue;
        }
        if (image.deliveries.size() >= tables_.limits().queued_per_session) {
            tables_.count(Drop::queue_full);
            continue;
        }
        image.deliveries.push_back({.position = message->position, .message = message, .qos = qos});
    }
    image.worked_through = later_of(worked_through(tables_), image.worked_through);
    image.header.provisional = true;
    return image;
}

void Adoption::forget_logs(const std::function<bool(const LogId&)>& are_over, Actions& out) {
    tables_.sessions.visit([&](Session& session) {
        std::erase_if(session.worked_ahead,
                      [&](const LogPosition& position) { return are_over(position.log); });
        std::erase_if(session.awaited, [&](const Delivery& delivery) {
            if (!are_over(delivery.position.log)) return false;
            tables_.log.append(out, [&] {
                return DeliveryEnded{session.header.client_id, delivery.position};
            });
            return true;
        });
    });
}

std::optional<SessionImage> Adoption::release(std::string_view client_id, Actions& out) {
    Session* session = tables_.sessions.find(client_id);
    if (session == nullptr) return std::nullopt;
    SessionImage image = image_of(*session, tables_);
    lifecycle_.erase(*session, out);
    return image;
}

std::optional<SessionImage> Adoption::move_away(std::string_view client_id, const LogId& to,
                                                std::uint64_t epochs, Actions& out) {
    Session* session = tables_.sessions.find(client_id);
    if (session == nullptr) return std::nullopt;
    SessionImage image = image_of(*session, tables_);
    image.header.epoch += epochs;
    tables_.log.append(out, [&] { return SessionMoved{image.header, to}; });
    lifecycle_.forget(*session);
    return image;
}

}  // namespace romano::broker
