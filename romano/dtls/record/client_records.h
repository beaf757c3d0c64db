// A client's records once its handshake is over: seals each under a number of its own, and opens
// each of the broker's once.
//
// **No number twice under one key.** The nonce of a record is its number. Whoever made the
// handshake has sealed records under the client's key, too: its Finished, and that again when it
// was lost. `number_above` says of what was sent where numbers are free; from there on the count
// rises with each record, also with one that was not sealed, and ends where it would wrap (RFC 6347
// section 4.1). Another handshake has other keys, and a copy, which would count alike, cannot be
// made.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "romano/base/bytes.h"
#include "romano/dtls/record/connection_id.h"
#include "romano/dtls/record/record.h"
#include "romano/dtls/record/record_cipher.h"
#include "romano/protection/replay_window.h"

namespace romano::dtls {

/// The least number that is above all of epoch 1 in a datagram that was sent, and above their
/// nonces as far as those look like ours: with GCM OpenSSL draws its own at random.
[[nodiscard]] std::uint64_t number_above(Bytes datagram);

class ClientRecords {
public:
    /// `brokers_id` is what the broker wants to be sent; empty: none. The broker's have no id.
    ClientRecords(const RecordKeys& keys, const ConnectionId& brokers_id,
                  std::uint64_t first_number)
        : keys_(keys), brokers_id_(brokers_id), next_(first_number) {}
    ClientRecords(const ClientRecords&) = delete;
    ClientRecords& operator=(const ClientRecords&) = delete;

    /// A whole record, valid until the next call; empty when the message is empty or too long, or
    /// the numbers are used up.
    [[nodiscard]] Bytes seal(ContentType type, Bytes message);
    [[nodiscard]] bool is_used_up() const { return next_ > most_number; }

    struct Heard {
        ContentType type;
        Bytes message;  // valid until the next call
    };
    /// Nothing when it is forged, or was there already.
    [[nodiscard]] std::optional<Heard> open(const Record& record);

    [[nodiscard]] bool has_brokers_id() const { return !brokers_id_.empty(); }

private:
    RecordKeys keys_;
    ConnectionId brokers_id_;
    std::uint64_t next_;
    protection::WindowOf<std::uint64_t> heard_;
    RecordCipher cipher_;
    std::vector<std::uint8_t> sealed_;
    std::vector<std::uint8_t> opened_;
};

}  // namespace romano::dtls
