// A log event as changes of rows: what broker::Mirror does to images, done to the file. The two
// agree after every workload (session_store_test).
//
// Only a lone broker writes here: all messages are of its own log, in this life or an earlier one,
// so that (incarnation, seq) names them.
#pragma once

#include "broker/core/log_event.h"
#include "broker/store/database.h"

namespace romano::store {

class EventRows {
public:
    EventRows(Database& database, std::uint64_t incarnation);

    /// The event at `seq` of the log. Within the caller's transaction.
    void write(broker::Seq seq, const broker::LogEvent& event);
    void put_retained(const broker::Message& message);
    /// Nothing is stored any more.
    void clear();

private:
    void on(const broker::SessionPut& event);
    void on(const broker::SessionChanged& event);
    void on(const broker::SessionErased& event);
    void on(const broker::WillChanged& event);
    void on(const broker::Subscribed& event);
    void on(const broker::Unsubscribed& event);
    void on(const broker::TopicBound& event);
    void on(const broker::Published& event);
    void on(const broker::Routed& event);
    void on(const broker::Cursor&) {}        // of peers' logs: there are none
    void on(const broker::SessionMoved&) {}  // nor other homes
    void on(const broker::Sealed&) {}
    void on(const broker::DeliveryStarted& event);
    void on(const broker::DeliveryReleased& event);
    void on(const broker::DeliveryEnded& event);
    void on(const broker::PublishReleased& event);

    void put_header(const broker::SessionHeader& header);
    void put_will(const broker::ClientId& client_id, const std::optional<broker::Will>& will);
    void put_subscription(const broker::ClientId& client_id,
                          const broker::Subscription& subscription);
    void put_topic(const broker::ClientId& client_id, const broker::TopicBinding& binding);
    /// Row of the message; written unless it is there.
    std::int64_t put_message(const broker::Message& message);
    void put_delivery(const broker::ClientId& client_id, std::int64_t message,
                      const broker::Delivery& delivery);
    void set_retained(const broker::Message& message, std::int64_t row);

    Database& database_;
    std::int64_t incarnation_;
    broker::Seq seq_ = 0;

    Statement put_session_;
    Statement change_session_;
    Statement forget_topics_;
    Statement erase_session_;
    Statement change_will_;
    Statement put_subscription_;
    Statement erase_subscription_;
    Statement put_topic_;
    Statement lose_session_;
    Statement put_unreleased_;
    Statement erase_unreleased_;
    Statement put_message_;
    Statement find_message_;
    Statement put_retained_;
    Statement erase_retained_;
    Statement put_delivery_;
    Statement start_delivery_;
    Statement release_delivery_;
    Statement erase_delivery_;
};

}  // namespace romano::store
