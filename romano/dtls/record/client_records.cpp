#include "romano/dtls/record/client_records.h"

#include <algorithm>

namespace romano::dtls {

std::uint64_t number_above(Bytes datagram) {
    std::uint64_t above = 0;
    while (const auto record = first_record(datagram)) {
        datagram = datagram.subspan(record->whole.size());
        if (record->epoch != 1) continue;
        above = std::max(above, record->number + 1);
        if (record->body.size() < explicit_nonce_octets) continue;
        const std::uint64_t nonce = be64(record->body, 0);
        const std::uint64_t number = nonce & most_number;
        if (nonce == epoch_and_number(1, number)) above = std::max(above, number + 1);
    }
    return above;
}

Bytes ClientRecords::seal(ContentType type, Bytes message) {
    if (is_used_up()) return {};
    sealed_.resize(message.size() + most_overhead);
    // Whatever becomes of it, this number was used.
    const std::size_t size = cipher_.seal(keys_.suite, keys_.client, type, next_++, message,
                                          sealed_, brokers_id_.octets());
    return Bytes{sealed_}.first(size);
}

std::optional<ClientRecords::Heard> ClientRecords::open(const Record& record) {
    if (heard_.has_seen(record.number)) return std::nullopt;
    opened_.resize(record.body.size());
    const auto opened = cipher_.open(keys_.suite, keys_.server, record, opened_);
    if (!opened) return std::nullopt;
    heard_.note(record.number);
    return Heard{opened->type, Bytes{opened_}.first(opened->size)};
}

}  // namespace romano::dtls
