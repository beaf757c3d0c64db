#include "broker/store/event_rows.h"

#include <optional>
#include <variant>

#include "broker/net/endpoint_text.h"

namespace romano::store {
namespace {

using broker::ClientId;
using broker::LogPosition;

template <typename Value>
std::int64_t number(Value value) {
    return static_cast<std::int64_t>(value);
}

std::int64_t incarnation_of(const LogPosition& position) {
    return number(position.log.incarnation);
}

// The first delivery of a message to a client: it works on its queue in order.
#define ROMANO_FIRST_DELIVERY                            \
    "(SELECT MIN(deliveries.id) FROM deliveries"         \
    " JOIN sessions ON deliveries.session = sessions.id" \
    " JOIN messages ON deliveries.message = messages.id" \
    " WHERE sessions.client_id = ?1 AND messages.incarnation = ?2 AND messages.seq = ?3)"

}  // namespace

EventRows::EventRows(Database& database, std::uint64_t incarnation)
    : database_(database),
      incarnation_(number(incarnation)),
      put_session_(database,
                   "INSERT INTO sessions(client_id, address, wireless_node_id, via, state, clean,"
                   " keep_alive_s, sleep_s, epoch, last_heard, departed)"
                   " VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)"),
      change_session_(database,
                      "UPDATE sessions SET address = ?2, wireless_node_id = ?3, via = ?4,"
                      " state = ?5, clean = ?6, keep_alive_s = ?7, sleep_s = ?8, epoch = ?9,"
                      " last_heard = ?10, departed = ?11 WHERE client_id = ?1"),
      forget_topics_(database,
                     "UPDATE topics SET known_to_client = 0"
                     " WHERE session = (SELECT id FROM sessions WHERE client_id = ?1)"),
      erase_session_(database, "DELETE FROM sessions WHERE client_id = ?1"),
      change_will_(database,
                   "UPDATE sessions SET will_topic = ?2, will_message = ?3, will_qos = ?4,"
                   " will_retain = ?5 WHERE client_id = ?1"),
      put_subscription_(database,
                        "INSERT INTO subscriptions(session, filter, type, predefined_id, granted)"
                        " SELECT id, ?2, ?3, ?4, ?5 FROM sessions WHERE client_id = ?1"
                        " ON CONFLICT DO UPDATE SET type = ?3, predefined_id = ?4, granted = ?5"),
      erase_subscription_(database,
                          "DELETE FROM subscriptions WHERE filter = ?2"
                          " AND session = (SELECT id FROM sessions WHERE client_id = ?1)"),
      put_topic_(database,
                 "INSERT OR REPLACE INTO topics(session, id, name, known_to_client)"
                 " SELECT id, ?2, ?3, ?4 FROM sessions WHERE client_id = ?1"),
      lose_session_(database, "UPDATE sessions SET state = ?2, departed = ?3 WHERE client_id = ?1"),
      put_unreleased_(database,
                      "INSERT INTO unreleased(session, msg_id)"
                      " SELECT id, ?2 FROM sessions WHERE client_id = ?1"),
      erase_unreleased_(database,
                        "DELETE FROM unreleased WHERE id = (SELECT MIN(unreleased.id)"
                        " FROM unreleased JOIN sessions ON unreleased.session = sessions.id"
                        " WHERE sessions.client_id = ?1 AND unreleased.msg_id = ?2)"),
      put_message_(database,
                   "INSERT INTO messages(incarnation, seq, topic, payload, qos, retain,"
                   " published_at) VALUES(?1, ?2, ?3, ?4, ?5, ?6, ?7)"),
      find_message_(database, "SELECT id FROM messages WHERE incarnation = ?1 AND seq = ?2"),
      put_retained_(database, "INSERT INTO retained(topic, message) VALUES(?1, ?2)"),
      erase_retained_(database, "DELETE FROM retained WHERE topic = ?1"),
      put_delivery_(database,
                    "INSERT INTO deliveries(session, message, qos, retain, stage, msg_id)"
                    " SELECT id, ?2, ?3, ?4, ?5, ?6 FROM sessions WHERE client_id = ?1"),
      start_delivery_(database,
                      "UPDATE deliveries SET stage = ?4, msg_id = ?5, qos = ?6"
                      " WHERE id = " ROMANO_FIRST_DELIVERY),
      release_delivery_(database,
                        "UPDATE deliveries SET stage = ?4 WHERE id = " ROMANO_FIRST_DELIVERY),
      erase_delivery_(database, "DELETE FROM deliveries WHERE id = " ROMANO_FIRST_DELIVERY) {}

void EventRows::write(broker::Seq seq, const broker::LogEvent& event) {
    seq_ = seq;
    std::visit([this](const auto& e) { on(e); }, event);
}

void EventRows::clear() {
    // Messages first: what refers to them would look for each.
    for (const char* sql :
         {"DELETE FROM messages", "DELETE FROM retained", "DELETE FROM sessions"}) {
        database_.execute(sql);
    }
}

void EventRows::on(const broker::SessionPut& event) {
    const broker::SessionImage& image = event.image;
    const ClientId& client_id = image.header.client_id;
    erase_session_.run(client_id);
    put_header(image.header);
    put_will(client_id, image.will);
    for (const auto& subscription : image.subscriptions) put_subscription(client_id, subscription);
    for (const auto& binding : image.topics) put_topic(client_id, binding);
    for (const auto msg_id : image.unreleased) put_unreleased_.run(client_id, number(msg_id));
    for (const auto& delivery : image.deliveries) {
        put_delivery(client_id, put_message(*delivery.message), delivery);
    }
}

void EventRows::put_header(const broker::SessionHeader& header) {
    put_session_.run(header.client_id, net::to_text(header.address.endpoint),
                     as_octets(header.address.wireless_node_id), net::to_text(header.via),
                     number(header.state), number(header.clean), number(header.keep_alive_s),
                     number(header.sleep_s), number(header.epoch), number(header.last_heard.value),
                     number(header.departed.value));
}

void EventRows::on(const broker::SessionChanged& event) {
    const broker::SessionHeader& header = event.header;
    change_session_.run(header.client_id, net::to_text(header.address.endpoint),
                        as_octets(header.address.wireless_node_id), net::to_text(header.via),
                        number(header.state), number(header.clean), number(header.keep_alive_s),
                        number(header.sleep_s), number(header.epoch),
                        number(header.last_heard.value), number(header.departed.value));
    if (event.forgets_topics) forget_topics_.run(header.client_id);
}

void EventRows::on(const broker::SessionErased& event) {
    erase_session_.run(event.client_id);
}

void EventRows::on(const broker::WillChanged& event) {
    put_will(event.client_id, event.will);
}

void EventRows::put_will(const ClientId& client_id, const std::optional<broker::Will>& will) {
    if (!will) {
        change_will_.run(client_id, nullptr, nullptr, nullptr, nullptr);
    } else {
        change_will_.run(client_id, will->topic, Bytes{will->message}, number(will->qos),
                         number(will->retain));
    }
}

void EventRows::on(const broker::Subscribed& event) {
    put_subscription(event.client_id, event.subscription);
}

void EventRows::put_subscription(const ClientId& client_id,
                                 const broker::Subscription& subscription) {
    put_subscription_.run(client_id, subscription.filter, number(subscription.type),
                          number(subscription.predefined_id), number(subscription.granted));
}

void EventRows::on(const broker::Unsubscribed& event) {
    erase_subscription_.run(event.client_id, event.filter);
}

void EventRows::on(const broker::TopicBound& event) {
    put_topic(event.client_id, event.binding);
}

void EventRows::put_topic(const ClientId& client_id, const broker::TopicBinding& binding) {
    put_topic_.run(client_id, number(binding.id), binding.name, number(binding.known_to_client));
}

void EventRows::on(const broker::Published& event) {
    if (!event.publisher.empty()) put_unreleased_.run(event.publisher, number(event.msg_id));
    if (!event.will_of.empty()) {
        lose_session_.run(event.will_of, number(broker::SessionState::lost),
                          number(event.message->published_at.value));
    }
    const broker::Message& message = *event.message;
    const bool is_kept = message.retain && !message.payload.empty();
    std::int64_t row = 0;
    if (is_kept || !event.routes.empty()) row = put_message(message);
    if (message.retain) set_retained(message, row);
    for (const broker::Route& route : event.routes) {
        put_delivery(route.client_id, row,
                     {.position = {}, .message = {}, .qos = route.qos, .retain = route.retain});
    }
}

void EventRows::put_retained(const broker::Message& message) {
    set_retained(message, message.payload.empty() ? 0 : put_message(message));
}

void EventRows::set_retained(const broker::Message& message, std::int64_t row) {
    erase_retained_.run(message.topic);
    if (!message.payload.empty()) put_retained_.run(message.topic, row);
}

std::int64_t EventRows::put_message(const broker::Message& message) {
    const LogPosition& position = message.position;
    std::int64_t row = 0;
    if (position.seq != seq_ || incarnation_of(position) != incarnation_) {
        find_message_.each([&row](const Row& found) { row = found.number(0); },
                           incarnation_of(position), number(position.seq));
    }
    if (row != 0) return row;
    put_message_.run(incarnation_of(position), number(position.seq), message.topic,
                     Bytes{message.payload}, number(message.qos), number(message.retain),
                     number(message.published_at.value));
    return database_.last_insert_id();
}

void EventRows::put_delivery(const ClientId& client_id, std::int64_t message,
                             const broker::Delivery& delivery) {
    put_delivery_.run(client_id, message, number(delivery.qos), number(delivery.retain),
                      number(delivery.stage), number(delivery.msg_id));
}

void EventRows::on(const broker::Routed& event) {
    std::optional<std::int64_t> row;
    find_message_.each([&row](const Row& found) { row = found.number(0); },
                       incarnation_of(event.message), number(event.message.seq));
    if (!row) return;
    for (const broker::Route& route : event.routes) {
        put_delivery(route.client_id, *row,
                     {.position = {}, .message = {}, .qos = route.qos, .retain = route.retain});
    }
}

void EventRows::on(const broker::DeliveryStarted& event) {
    start_delivery_.run(event.client_id, incarnation_of(event.message), number(event.message.seq),
                        number(broker::DeliveryStage::published), number(event.msg_id),
                        number(event.qos));
}

void EventRows::on(const broker::DeliveryReleased& event) {
    release_delivery_.run(event.client_id, incarnation_of(event.message), number(event.message.seq),
                          number(broker::DeliveryStage::released));
}

void EventRows::on(const broker::DeliveryEnded& event) {
    erase_delivery_.run(event.client_id, incarnation_of(event.message), number(event.message.seq));
}

void EventRows::on(const broker::PublishReleased& event) {
    erase_unreleased_.run(event.client_id, number(event.msg_id));
}

}  // namespace romano::store
