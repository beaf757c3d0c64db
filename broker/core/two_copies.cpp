#include "broker/core/two_copies.h"

#include <algorithm>
#include <utility>

#include "romano/mqttsn/topic.h"

namespace romano::broker {

using mqttsn::Qos;

namespace {

/// Two homes had the session, and the client was heard last by the one that gives way: what it was
/// told there, of topic ids and subscriptions, stays true. False when that is nothing new.
bool learn(SessionImage& image, const SessionImage& told) {
    bool is_new = false;
    for (const TopicBinding& binding : told.topics) {
        const auto at = std::ranges::lower_bound(image.topics, binding.id, {}, &TopicBinding::id);
        if (at == image.topics.end() || at->id != binding.id) {
            image.topics.insert(at, binding);
        } else if (*at != binding) {
            *at = binding;
        } else {
            continue;
        }
        is_new = true;
    }
    for (const Subscription& subscription : told.subscriptions) {
        const auto same =
            std::ranges::find(image.subscriptions, subscription.filter, &Subscription::filter);
        if (same == image.subscriptions.end()) {
            image.subscriptions.push_back(subscription);
        } else if (*same != subscription) {
            *same = subscription;
        } else {
            continue;
        }
        is_new = true;
    }
    return is_new;
}

/// The client fell asleep at the home that stays, and connected at the other one since: who takes
/// it for asleep sends it nothing. False when that is nothing new.
bool learn_awoken(SessionHeader& stays, const SessionHeader& told) {
    const bool sleeps = stays.state == SessionState::asleep || stays.state == SessionState::awake;
    if (!sleeps || told.state != SessionState::active) return false;
    stays.state = told.state;
    stays.keep_alive_s = told.keep_alive_s;
    stays.sleep_s = told.sleep_s;
    return true;
}

/// What the client began to publish last at the home that gives way is published, though the other
/// one may have heard it later: it answered what that one sent. False when that is nothing new.
bool learn_published(SessionImage& image, const SessionImage& told) {
    if (told.header.last_published <= image.header.last_published) return false;
    image.header.last_published = told.header.last_published;
    bool is_new = false;
    for (const mqttsn::MsgId id : told.unreleased) {
        if (std::ranges::count(image.unreleased, id) > 0) continue;
        image.unreleased.push_back(id);
        is_new = true;
    }
    return is_new;
}

/// What the copy that gives way has begun to send at QoS 2, and only waits or is missed in the one
/// that stays, goes on under its id: the client may have it. So does what the client has received
/// there for certain, though the copy that stays has begun, too. False when there is nothing of the
/// kind.
bool resume_exchanges(SessionImage& stays, std::vector<MessagePtr>& missed,
                      const SessionImage& gives_way) {
    bool resumes = false;
    for (const Delivery& begun : gives_way.deliveries) {
        if (begun.qos != Qos::exactly_once || begun.stage == DeliveryStage::queued) continue;
        const bool was_missed = std::erase_if(missed, [&](const MessagePtr& message) {
                                    return message->position == begun.position;
                                }) != 0;
        if (was_missed) stays.deliveries.push_back(begun);
        const auto waiting =
            std::ranges::find(stays.deliveries, begun.position, &Delivery::position);
        if (waiting == stays.deliveries.end() || waiting->qos != Qos::exactly_once) continue;
        const bool is_further =
            begun.stage == DeliveryStage::released && waiting->stage == DeliveryStage::published;
        if (waiting->stage == DeliveryStage::queued || is_further) {
            waiting->stage = begun.stage;
            waiting->msg_id = begun.msg_id;
            resumes = true;
        }
    }
    return resumes;
}

/// Of the QoS 2 exchange that the copy which gives way had open, and the one that stays has not.
mqttsn::MsgId left_open(const SessionImage& gives_way, const SessionImage& stays) {
    const auto is_open = [](const Delivery& delivery) {
        return delivery.qos == Qos::exactly_once && delivery.msg_id != mqttsn::no_msg_id;
    };
    const auto open = std::ranges::find_if(gives_way.deliveries, is_open);
    if (open == gives_way.deliveries.end()) return mqttsn::no_msg_id;
    const bool goes_on = std::ranges::count(stays.deliveries, open->msg_id, &Delivery::msg_id) > 0;
    return goes_on ? mqttsn::no_msg_id : open->msg_id;
}

/// Of `missed`, and of what waits in the copy that stays, what the other home already delivered, as
/// its copy tells: it worked through it and has it in no queue any more. A home that was cut off
/// hears of it only after the heal, when its copy may win. True when something waited.
bool leave_out_delivered(SessionImage& stays, std::vector<MessagePtr>& missed,
                         const SessionImage& gives_way) {
    if (!keeps_messages(gives_way.header)) return false;  // nothing was queued for it
    const auto is_delivered = [&](const MessagePtr& message) {
        const LogPosition& position = message->position;
        if (position.seq > worked_through(gives_way, position.log)) return false;
        const bool was_queued =
            std::ranges::any_of(gives_way.subscriptions, [&](const Subscription& subscription) {
                return subscription.granted != Qos::at_most_once &&
                       mqttsn::matches(subscription.filter, message->topic);
            });
        const bool still_waits =
            std::ranges::count(gives_way.deliveries, position, &Delivery::position) > 0;
        return was_queued && !still_waits;
    };
    std::erase_if(missed, is_delivered);
    // What the client has received here: it knows, and waits for its end.
    return std::erase_if(stays.deliveries, [&](const Delivery& delivery) {
               return delivery.message && !delivery.retain &&
                      delivery.stage != DeliveryStage::released && is_delivered(delivery.message);
           }) != 0;
}

/// P7: the other home lost the client, and said its will, when it had been silent to both for
/// longer than a client that lives: it is lost to this copy, too. That one's broker could not know,
/// for the client might have been with the other one.
bool is_lost_elsewhere(const SessionHeader& own, const SessionHeader& other) {
    if (!is_connected(own) || other.state != SessionState::lost) return false;
    const std::uint64_t silence_s = std::max(own.keep_alive_s, own.sleep_s);
    return other.departed.unix_ms() > own.last_heard.unix_ms() + 1000 * silence_s;
}

}  // namespace

Settled settle(SessionImage own, SessionImage comes, std::vector<MessagePtr>& missed) {
    Settled settled{.comes = outranks(comes.header, own.header)};
    SessionImage& stays = settled.comes ? comes : own;
    const SessionImage& other = settled.comes ? own : comes;
    const SessionImage before = stays;
    settled.last_msg_id_elsewhere = other.last_msg_id;
    const bool leaves_out = leave_out_delivered(stays, missed, other);
    const bool resumes = resume_exchanges(stays, missed, other);
    settled.unfinished = left_open(other, stays);
    if (settled.unfinished == mqttsn::no_msg_id) settled.unfinished = left_open(before, stays);
    bool learns = learn_published(stays, other);
    if (other.header.last_heard > stays.header.last_heard) {
        learns |= learn(stays, other);
        learns |= learn_awoken(stays.header, other.header);
    }
    // A mirror's copy that comes may have been heard since.
    const bool is_lost = !settled.comes && is_lost_elsewhere(stays.header, other.header);
    if (is_lost) {
        stays.header.state = SessionState::lost;
        stays.header.departed = other.header.departed;
    }
    settled.is_new = settled.comes || leaves_out || resumes || learns || is_lost;
    settled.image = std::move(stays);
    return settled;
}

}  // namespace romano::broker
