#include "romano/dtls/client_end.h"

#include <utility>

#include "romano/dtls/record/alert.h"

namespace romano::dtls {

ClientEnd::ClientEnd(std::string identity, const protection::Key& key, Send send,
                     const char* suites, Wants wants)
    : send_(std::move(send)), handshake_(std::move(identity), key, send_, suites, wants) {}

void ClientEnd::connect() {
    records_.reset();
    handshake_.begin();
}

Bytes ClientEnd::open(Bytes datagram) {
    Bytes message;
    while (message.empty()) {
        const auto record = first_record(datagram);
        if (!record) break;
        datagram = datagram.subspan(record->whole.size());
        if (is_connected()) {
            message = take(*record);
        } else if (const auto agreed = handshake_.take(record->whole)) {
            records_.emplace(agreed->keys, agreed->brokers_id, agreed->first_number);
        }
    }
    return message;
}

/// What comes of a handshake still is passed over: a Finished that came twice, which only who has
/// the last flight answers, or a wish for another handshake (RFC 5246 section 7.4.1.1).
Bytes ClientEnd::take(const Record& record) {
    const auto heard = records_->open(record);
    if (!heard) return {};
    if (heard->type == ContentType::application_data) return heard->message;
    if (heard->type != ContentType::alert) return {};
    const auto alert = alert_in(heard->message);
    if (alert == Alert::goodbye) close();
    if (alert == Alert::fatal) records_.reset();
    return {};
}

bool ClientEnd::seal(Bytes message) {
    return say(ContentType::application_data, message);
}

bool ClientEnd::say(ContentType type, Bytes message) {
    if (!is_connected()) return false;
    const Bytes record = records_->seal(type, message);
    if (!record.empty()) send_(record);
    const bool is_sent = !record.empty();
    if (records_->is_used_up()) records_.reset();
    return is_sent;
}

void ClientEnd::close() {
    (void)say(ContentType::alert, goodbye);
    records_.reset();
    handshake_.give_up();
}

}  // namespace romano::dtls
