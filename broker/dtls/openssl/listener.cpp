#include "broker/dtls/openssl/listener.h"

#include "romano/mqttsn/decode.h"

namespace romano::dtls {

Listener::Listener(const Speaker& self, const protection::Key& secret,
                   const std::optional<Certificates>& certificates)
    : clients_(self),
      handshakes_(
          secret,
          [this](std::string_view identity) -> std::optional<protection::Key> {
              const protection::RobotKey* key = clients_.key_of(identity);
              if (key == nullptr) return std::nullopt;
              return protection::pre_shared_key(*key);
          },
          certificates) {}

void Listener::take(Instant now, const Path& path, Bytes datagram, broker::Actions& out,
                    const Deliver& deliver) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (frame && frame->type == mqttsn::MsgType::searchgw) return deliver(datagram);  // a hint
    while (!datagram.empty()) {
        const auto record = first_record(datagram);
        if (!record) return clients_.count(Refusal::malformed);
        datagram = datagram.subspan(record->whole.size());
        take_record(now, path, *record, out, deliver);
    }
}

void Listener::take_record(Instant now, const Path& path, const Record& record,
                           broker::Actions& out, const Deliver& deliver) {
    const bool is_protected = record.epoch == 1 && (record.type == ContentType::application_data ||
                                                    record.type == ContentType::alert);
    if (is_protected) {
        const Bytes message = clients_.open(path, record, out);
        if (message.empty()) return;
        if (handshakes_.size() != 0) handshakes_.on_heard(path);
        return deliver(message);
    }
    if (record.epoch > 1 || record.type == ContentType::application_data) {
        return clients_.count(Refusal::malformed);
    }
    const std::uint64_t failed = handshakes_.failed();
    if (const auto agreed = handshakes_.take(now, path, record, out)) clients_.add(*agreed);
    if (handshakes_.failed() != failed) clients_.count(Refusal::handshake_failed);
}

}  // namespace romano::dtls
