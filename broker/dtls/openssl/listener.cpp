#include "broker/dtls/openssl/listener.h"

#include "broker/dtls/own_id.h"
#include "romano/mqttsn/decode.h"

namespace romano::dtls {

Listener::Listener(const Speaker& self, const protection::Key& secret,
                   const std::optional<Certificates>& certificates)
    : clients_(self),
      handshakes_(
          self.place, secret,
          [this](std::string_view identity) -> std::optional<protection::Key> {
              const protection::RobotKey* key = clients_.key_of(identity);
              if (key == nullptr) return std::nullopt;
              return protection::pre_shared_key(*key);
          },
          certificates) {}

void Listener::take(Instant now, const Path& path, Bytes datagram, broker::Actions& out,
                    const Deliver& deliver) {
    const auto frame = mqttsn::decode_frame(datagram);
    if (frame && frame->type == mqttsn::MsgType::searchgw)
        return deliver({path, datagram});  // a hint
    // A ClientHello is a flight of its own: who sends many at once is answered once.
    for (bool is_first = true; !datagram.empty(); is_first = false) {
        const auto record = first_record(datagram, own_id_octets);
        if (!record || (!is_first && client_hello_in(*record))) {
            return clients_.count(Refusal::malformed);
        }
        datagram = datagram.subspan(record->whole.size());
        take_record(now, path, *record, out, deliver);
    }
}

void Listener::take_record(Instant now, const Path& path, const Record& record,
                           broker::Actions& out, const Deliver& deliver) {
    if (record.type == ContentType::with_id) {
        const auto of_handshake = handshakes_.without_id(path, record);
        return of_handshake ? take_of_handshake(now, path, *of_handshake, out)
                            : take_protected(path, record, out, deliver);
    }
    const bool is_protected = record.epoch == 1 && (record.type == ContentType::application_data ||
                                                    record.type == ContentType::alert);
    if (is_protected) return take_protected(path, record, out, deliver);
    if (record.epoch > 1 || record.type == ContentType::application_data) {
        return clients_.count(Refusal::malformed);
    }
    take_of_handshake(now, path, record, out);
}

void Listener::take_protected(const Path& path, const Record& record, broker::Actions& out,
                              const Deliver& deliver) {
    const Message message = clients_.open(path, record, out);
    if (message.octets.empty()) return;
    if (handshakes_.size() != 0) handshakes_.on_heard(path);
    deliver(message);
}

void Listener::take_of_handshake(Instant now, const Path& path, const Record& record,
                                 broker::Actions& out) {
    const std::uint64_t failed = handshakes_.failed();
    const std::uint64_t crowded_out = handshakes_.crowded_out();
    if (const auto agreed = handshakes_.take(now, path, record, out)) clients_.add(*agreed);
    if (handshakes_.failed() != failed) clients_.count(Refusal::handshake_failed);
    if (handshakes_.crowded_out() != crowded_out) clients_.count(Refusal::handshake_rate);
}

}  // namespace romano::dtls
