#include "broker/core/session_image.h"

#include <algorithm>

namespace romano::broker {
namespace {

bool same_delivery(const Delivery& a, const Delivery& b) {
    return a.position == b.position && a.qos == b.qos && a.retain == b.retain &&
           a.stage == b.stage && a.msg_id == b.msg_id;
}

}  // namespace

Seq worked_through(const SessionImage& image, const LogId& log) {
    return seq_of(image.worked_through, log).value_or(0);
}

bool same_state(const SessionImage& a, const SessionImage& b) {
    SessionHeader header = a.header;
    header.last_heard = b.header.last_heard;
    header.departed = b.header.departed;
    header.last_published = b.header.last_published;
    return header == b.header && a.will == b.will && a.subscriptions == b.subscriptions &&
           a.topics == b.topics && std::ranges::equal(a.deliveries, b.deliveries, same_delivery) &&
           a.unreleased == b.unreleased && a.worked_through == b.worked_through;
}

}  // namespace romano::broker
