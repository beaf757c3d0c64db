// Connection IDs (RFC 9146) beside OpenSSL 3.0, which knows none: it is told of the extension, and
// between it and the network the records of epoch 1 are opened and sealed again, with the id out
// there and without it in here, under their keys and numbers. What OpenSSL sealed is seen by
// nobody, so no nonce is seen with two texts.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "romano/base/bytes.h"
#include "romano/dtls/record/connection_id.h"
#include "romano/dtls/record/record_cipher.h"
#include "romano/dtls/session_keys.h"

namespace romano::dtls {

/// RFC 9146 section 3.
inline constexpr unsigned int connection_id_extension = 54;
/// Its body: a length and the id that whoever sends it wants to be sent. Nothing when it is none,
/// or longer than ours may be; `is_malformed` says which.
[[nodiscard]] std::optional<ConnectionId> id_in_extension(Bytes body, bool& is_malformed);

enum class End : std::uint8_t { client, server };

class OpensslWithIds {
public:
    explicit OpensslWithIds(End own) : own_(own) {}

    /// What OpenSSL wrote, as the peer wants it, valid until the next call; empty when it takes
    /// keys, and there are none yet.
    [[nodiscard]] Bytes with_id(const std::optional<SessionKeys>& session, Bytes datagram,
                                const ConnectionId& peers);
    /// What the peer wrote, as OpenSSL wants it, valid until the next call; nothing when it is not
    /// of the peer.
    [[nodiscard]] std::optional<Record> without_id(const std::optional<SessionKeys>& session,
                                                   const Record& record);

private:
    [[nodiscard]] bool seal_again(const RecordKeys& keys, End writer, const Record& record,
                                  Bytes id);

    End own_;
    RecordCipher cipher_;
    std::vector<std::uint8_t> message_;
    std::vector<std::uint8_t> out_;
};

}  // namespace romano::dtls
