#include "broker/dtls/record.h"

namespace romano::dtls {
namespace {

std::uint64_t be48(Bytes octets, std::size_t at) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 6; ++i) value = value << 8U | octets[at + i];
    return value;
}

}  // namespace

std::optional<Record> first_record(Bytes datagram) {
    if (datagram.size() < header_octets) return std::nullopt;
    const std::uint8_t type = datagram[0];
    if (type < static_cast<std::uint8_t>(ContentType::change_cipher_spec) ||
        type > static_cast<std::uint8_t>(ContentType::application_data)) {
        return std::nullopt;
    }
    const std::size_t body = be16(datagram, 11);
    if (body > datagram.size() - header_octets) return std::nullopt;
    return Record{.type = ContentType{type},
                  .version = be16(datagram, 1),
                  .epoch = be16(datagram, 3),
                  .number = be48(datagram, 5),
                  .body = datagram.subspan(header_octets, body),
                  .whole = datagram.first(header_octets + body)};
}

void put_be64(MutableBytes octets, std::size_t at, std::uint64_t value) {
    for (std::size_t i = 0; i < 8; ++i) {
        octets[at + i] = static_cast<std::uint8_t>(value >> (56 - 8 * i));
    }
}

void put_header(MutableBytes out, ContentType type, std::uint64_t epoch_and_number,
                std::size_t body_octets) {
    out[0] = static_cast<std::uint8_t>(type);
    put_be16(out, 1, version_1_2);
    put_be64(out, 3, epoch_and_number);
    put_be16(out, 11, static_cast<std::uint16_t>(body_octets));
}

}  // namespace romano::dtls
