#include "romano/dtls/record/record.h"

#include <algorithm>

namespace romano::dtls {
namespace {

constexpr std::size_t id_at = 11;

}  // namespace

std::optional<Record> first_record(Bytes datagram, std::size_t id_octets) {
    if (datagram.empty()) return std::nullopt;
    const ContentType type{datagram[0]};
    const bool has_id = type == ContentType::with_id && id_octets != 0;
    if (!has_id &&
        (type < ContentType::change_cipher_spec || type > ContentType::application_data)) {
        return std::nullopt;
    }
    const std::size_t header = header_octets + (has_id ? id_octets : 0);
    if (datagram.size() < header) return std::nullopt;
    const std::size_t body = be16(datagram, header - 2);
    if (body > datagram.size() - header) return std::nullopt;
    return Record{.type = type,
                  .version = be16(datagram, 1),
                  .epoch = be16(datagram, 3),
                  .number = be64(datagram, 3) & most_number,
                  .id = datagram.subspan(id_at, header - header_octets),
                  .body = datagram.subspan(header, body),
                  .whole = datagram.first(header + body)};
}

std::uint64_t be64(Bytes octets, std::size_t at) {
    std::uint64_t value = 0;
    for (const std::uint8_t octet : octets.subspan(at, 8)) value = value << 8U | octet;
    return value;
}

void put_be64(MutableBytes octets, std::size_t at, std::uint64_t value) {
    for (std::size_t i = 0; i < 8; ++i) {
        octets[at + i] = static_cast<std::uint8_t>(value >> (56 - 8 * i));
    }
}

void put_header(MutableBytes out, ContentType type, std::uint64_t epoch_and_number, Bytes id,
                std::size_t body_octets) {
    out[0] = static_cast<std::uint8_t>(type);
    put_be16(out, 1, version_1_2);
    put_be64(out, 3, epoch_and_number);
    std::copy(id.begin(), id.end(), out.subspan(id_at).begin());
    put_be16(out, id_at + id.size(), static_cast<std::uint16_t>(body_octets));
}

}  // namespace romano::dtls
