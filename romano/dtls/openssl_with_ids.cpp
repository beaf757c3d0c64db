#include "romano/dtls/openssl_with_ids.h"

namespace romano::dtls {

std::optional<ConnectionId> id_in_extension(Bytes body, bool& is_malformed) {
    is_malformed = body.empty() || body[0] != body.size() - 1;
    return is_malformed ? std::nullopt : ConnectionId::of(body.subspan(1));
}

Bytes OpensslWithIds::with_id(const std::optional<SessionKeys>& session, Bytes datagram,
                              const ConnectionId& peers) {
    out_.clear();
    while (const auto record = first_record(datagram)) {
        datagram = datagram.subspan(record->whole.size());
        if (record->epoch == 0) {
            out_.insert(out_.end(), record->whole.begin(), record->whole.end());
            continue;
        }
        if (!session || !seal_again(session->keys, own_, *record, peers.octets())) return {};
    }
    return out_;
}

std::optional<Record> OpensslWithIds::without_id(const std::optional<SessionKeys>& session,
                                                 const Record& record) {
    out_.clear();
    const End peer = own_ == End::client ? End::server : End::client;
    if (!session || !seal_again(session->keys, peer, record, {})) return std::nullopt;
    return first_record(out_);
}

/// Behind what there is of `out_`.
bool OpensslWithIds::seal_again(const RecordKeys& keys, End writer, const Record& record,
                                Bytes id) {
    message_.resize(record.body.size());
    const WriteKey& key = writer == End::client ? keys.client : keys.server;
    const auto opened = cipher_.open(keys.suite, key, record, message_);
    if (!opened) return false;
    const std::size_t before = out_.size();
    out_.resize(before + opened->size + overhead(keys.suite, id.size()));
    const Bytes message = Bytes{message_}.first(opened->size);
    return cipher_.seal(keys.suite, key, opened->type, record.number, message,
                        MutableBytes{out_}.subspan(before), id) != 0;
}

}  // namespace romano::dtls
