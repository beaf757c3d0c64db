// A client's handshakes of DTLS 1.2 with a pre-shared key (RFC 4279), by OpenSSL: records in,
// datagrams out, and in the end what the client's records are sealed by. A shell, for OpenSSL's
// timers read the real clock; no socket.
//
// When a handshake is over, OpenSSL is gone: of a full one the broker has the last flight, so a
// client has nothing to repeat (RFC 6347 section 4.2.4). It resumes no session.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/dtls/record/connection_id.h"
#include "romano/dtls/record/record_cipher.h"
#include "romano/protection/keys.h"

namespace romano::dtls {

class ClientHandshake {
public:
    using Send = std::function<void(Bytes datagram)>;

    enum class Wants : std::uint8_t { connection_id, none };

    /// What it agrees on.
    struct Agreed {
        RecordKeys keys;
        ConnectionId brokers_id;         // empty: it gave none
        std::uint64_t first_number = 0;  // of records that are not the handshake's
    };

    /// Throws std::runtime_error when OpenSSL cannot do it. `suites` as for `openssl ciphers`, of
    /// those of Suite.
    ClientHandshake(std::string identity, const protection::Key& key, Send send, const char* suites,
                    Wants wants);
    ~ClientHandshake();

    /// In place of one that goes on.
    void begin();
    void give_up();
    [[nodiscard]] bool goes_on() const;
    /// A record of the broker. The handshake goes on no more when there is something, or it has
    /// failed.
    [[nodiscard]] std::optional<Agreed> take(Bytes record);
    /// When on_time() is to be called, while it goes on; earlier calls are harmless.
    [[nodiscard]] std::optional<Duration> due_in() const;
    /// Repeats what may be lost. After about ten minutes without an answer it fails.
    void on_time();

private:
    struct Openssl;

    std::unique_ptr<Openssl> openssl_;
};

}  // namespace romano::dtls
