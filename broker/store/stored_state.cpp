#include "broker/store/stored_state.h"

#include <string>
#include <unordered_map>
#include <utility>

#include "broker/net/endpoint_text.h"

namespace romano::store {
namespace {

using broker::SessionImage;

template <typename Value>
Value value(const Row& row, int column) {
    return static_cast<Value>(row.number(column));
}

std::string text(const Row& row, int column) {
    return std::string{row.text(column)};
}

std::vector<std::uint8_t> octets(const Row& row, int column) {
    const Bytes view = row.octets(column);
    return {view.begin(), view.end()};
}

/// An interface may be gone since: then the client is not reachable until it is heard.
Endpoint endpoint(const Row& row, int column) {
    return net::parse_service_address(row.text(column)).value_or(Endpoint{});
}

class Reader {
public:
    Reader(Database& database, broker::BrokerId self) : database_(database), self_(self) {}

    StoredState read() {
        read_sessions();
        read_lists();
        read_messages();
        read_deliveries();
        each("SELECT message FROM retained ORDER BY topic", [this](const Row& row) {
            if (const auto message = message_at(row.number(0))) state_.retained.push_back(message);
        });
        return std::move(state_);
    }

private:
    template <typename Visitor>
    void each(const char* sql, Visitor&& visit) {
        Statement(database_, sql).each(visit);
    }

    [[nodiscard]] SessionImage* session_at(std::int64_t row) {
        const auto found = sessions_.find(row);
        return found == sessions_.end() ? nullptr : &state_.sessions[found->second];
    }
    [[nodiscard]] broker::MessagePtr message_at(std::int64_t row) const {
        const auto found = messages_.find(row);
        return found == messages_.end() ? broker::MessagePtr{} : found->second;
    }

    void read_sessions();
    void read_lists();
    void read_messages();
    void read_deliveries();

    Database& database_;
    broker::BrokerId self_;
    StoredState state_;
    std::unordered_map<std::int64_t, std::size_t> sessions_;
    std::unordered_map<std::int64_t, broker::MessagePtr> messages_;
};

void Reader::read_sessions() {
    each(
        "SELECT id, client_id, address, wireless_node_id, via, state, clean, keep_alive_s, sleep_s,"
        " epoch, last_heard, will_topic, will_message, will_qos, will_retain, departed"
        " FROM sessions ORDER BY client_id",
        [this](const Row& row) {
            SessionImage image;
            broker::SessionHeader& header = image.header;
            header.client_id = text(row, 1);
            header.address = {endpoint(row, 2), text(row, 3)};
            header.via = endpoint(row, 4);
            header.state = value<broker::SessionState>(row, 5);
            header.clean = row.number(6) != 0;
            header.keep_alive_s = value<std::uint16_t>(row, 7);
            header.sleep_s = value<std::uint16_t>(row, 8);
            header.epoch = value<std::uint64_t>(row, 9);
            header.last_heard = {value<std::uint64_t>(row, 10)};
            header.departed = {value<std::uint64_t>(row, 15)};
            if (!row.is_null(11)) {
                image.will = {text(row, 11), octets(row, 12), value<mqttsn::Qos>(row, 13),
                              row.number(14) != 0};
            }
            sessions_.emplace(row.number(0), state_.sessions.size());
            state_.sessions.push_back(std::move(image));
        });
}

void Reader::read_lists() {
    each("SELECT session, filter, type, predefined_id, granted FROM subscriptions ORDER BY id",
         [this](const Row& row) {
             SessionImage* image = session_at(row.number(0));
             if (image == nullptr) return;
             image->subscriptions.push_back({text(row, 1), value<mqttsn::TopicIdType>(row, 2),
                                             value<mqttsn::TopicId>(row, 3),
                                             value<mqttsn::Qos>(row, 4)});
         });
    each("SELECT session, id, name, known_to_client FROM topics ORDER BY session, id",
         [this](const Row& row) {
             SessionImage* image = session_at(row.number(0));
             if (image == nullptr) return;
             image->topics.push_back(
                 {value<mqttsn::TopicId>(row, 1), text(row, 2), row.number(3) != 0});
         });
    each("SELECT session, msg_id FROM unreleased ORDER BY id", [this](const Row& row) {
        SessionImage* image = session_at(row.number(0));
        if (image != nullptr) image->unreleased.push_back(value<mqttsn::MsgId>(row, 1));
    });
}

void Reader::read_messages() {
    each(
        "SELECT id, incarnation, seq, topic, payload, qos, retain, published_at FROM messages",
        [this](const Row& row) {
            messages_.emplace(
                row.number(0),
                broker::MessagePtr{broker::Message{
                    .topic = text(row, 3),
                    .payload = octets(row, 4),
                    .qos = value<mqttsn::Qos>(row, 5),
                    .retain = row.number(6) != 0,
                    .position = {{self_, value<std::uint64_t>(row, 1)}, value<broker::Seq>(row, 2)},
                    .published_at = {value<std::uint64_t>(row, 7)}}});
        });
}

void Reader::read_deliveries() {
    each("SELECT session, message, qos, retain, stage, msg_id FROM deliveries ORDER BY id",
         [this](const Row& row) {
             SessionImage* image = session_at(row.number(0));
             const auto message = message_at(row.number(1));
             if (image == nullptr || !message) return;
             image->deliveries.push_back({.position = message->position,
                                          .message = message,
                                          .qos = value<mqttsn::Qos>(row, 2),
                                          .retain = row.number(3) != 0,
                                          .stage = value<broker::DeliveryStage>(row, 4),
                                          .msg_id = value<mqttsn::MsgId>(row, 5)});
         });
}

}  // namespace

StoredState read_state(Database& database, broker::BrokerId self) {
    return Reader(database, self).read();
}

std::uint64_t last_incarnation(Database& database) {
    return static_cast<std::uint64_t>(
        database.number("SELECT ifnull(MAX(incarnation), 0) FROM messages"));
}

}  // namespace romano::store
