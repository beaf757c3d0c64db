#include "broker/core/session_image_of.h"

namespace romano::broker {

SessionImage bare_image_of(const Session& session) {
    SessionImage image{.header = session.header,
                       .will = session.will,
                       .subscriptions = session.subscriptions,
                       .topics = session.topics.bindings(),
                       .deliveries = session.awaited,
                       .unreleased = session.unreleased,
                       .worked_through = session.worked_ahead,
                       .last_msg_id = mqttsn::MsgId{session.last_msg_id}};
    for (const Delivery& delivery : session.queue) {
        if (delivery.qos != mqttsn::Qos::at_most_once) image.deliveries.push_back(delivery);
    }
    return image;
}

std::vector<LogPosition> worked_through(const Tables& tables) {
    std::vector<LogPosition> positions = tables.cursors.all();
    if (tables.log.writes()) positions.push_back({tables.log.id(), tables.log.last()});
    return positions;
}

SessionImage image_of(const Session& session, const Tables& tables) {
    SessionImage image = bare_image_of(session);
    image.worked_through = later_of(worked_through(tables), image.worked_through);
    return image;
}

}  // namespace romano::broker
