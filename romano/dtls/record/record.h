// Records of DTLS 1.2 (RFC 6347 section 4.1, with a Connection ID RFC 9146 section 4): the octets
// in front of each, and nothing of what is inside. A datagram holds one or more.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "romano/base/bytes.h"

namespace romano::dtls {

enum class ContentType : std::uint8_t {
    change_cipher_spec = 20,
    alert = 21,
    handshake = 22,
    application_data = 23,
    with_id = 25,  // tls12_cid: has a Connection ID, and its type inside
};

inline constexpr std::size_t header_octets = 13;
inline constexpr std::uint16_t version_1_2 = 0xFEFD;
/// RFC 6347 section 4.1: sequence numbers have 48 bits.
inline constexpr std::uint64_t most_number = (std::uint64_t{1} << 48U) - 1;

struct Record {
    ContentType type = ContentType::alert;
    std::uint16_t version = 0;
    std::uint16_t epoch = 0;
    std::uint64_t number = 0;
    Bytes id{};  // of with_id alone
    Bytes body{};
    Bytes whole{};  // with its header
};

/// The first record of a datagram, a view into it; nothing when it is none of the types, or its
/// length goes beyond the datagram. Who reads it gives out Connection IDs of `id_octets`, or none:
/// their length does not stand in a record.
[[nodiscard]] std::optional<Record> first_record(Bytes datagram, std::size_t id_octets = 0);

/// Epoch and number as one, as they stand in a header.
[[nodiscard]] constexpr std::uint64_t epoch_and_number(std::uint16_t epoch, std::uint64_t number) {
    return std::uint64_t{epoch} << 48U | number;
}

[[nodiscard]] std::uint64_t be64(Bytes octets, std::size_t at);
void put_be64(MutableBytes octets, std::size_t at, std::uint64_t value);

/// `out` has room for header_octets and the id.
void put_header(MutableBytes out, ContentType type, std::uint64_t epoch_and_number, Bytes id,
                std::size_t body_octets);

}  // namespace romano::dtls
