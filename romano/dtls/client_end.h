// A client's end of DTLS 1.2 with a pre-shared key (RFC 4279), by OpenSSL: handshake, records,
// replay window. No socket: datagrams in, datagrams out. A shell, for OpenSSL's timers read the
// real clock.
//
// It asks the broker for a Connection ID (RFC 9146) and wants none for itself. With one its address
// may change, as a NAT does it: the association goes on.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/protection/keys.h"

namespace romano::dtls {

class ClientEnd {
public:
    using Send = std::function<void(Bytes datagram)>;

    enum class Wants : std::uint8_t { connection_id, none };

    /// Throws std::runtime_error when OpenSSL cannot do it. `suites` as for `openssl ciphers`.
    ClientEnd(std::string identity, const protection::Key& key, Send send,
              const char* suites = default_suites, Wants wants = Wants::connection_id);
    ~ClientEnd();

    /// A handshake, from its beginning.
    void connect();
    [[nodiscard]] bool is_connected() const;
    /// The broker has closed the association, or the handshake has failed.
    [[nodiscard]] bool is_closed() const;
    /// The broker knows it from any address.
    [[nodiscard]] bool may_roam() const;

    /// The message in it, valid until the next call; empty when there is none.
    [[nodiscard]] Bytes open(Bytes datagram);
    /// False when there is no association.
    bool seal(Bytes message);
    /// When on_time() is to be called, while a handshake goes on; earlier calls are harmless.
    [[nodiscard]] std::optional<Duration> due_in() const;
    /// Repeats what may be lost. After about ten minutes without an answer the handshake fails.
    void on_time();
    /// Says goodbye.
    void close();

    static constexpr const char* default_suites = "PSK-AES128-CCM8:PSK-AES128-GCM-SHA256";

private:
    struct Session;

    std::unique_ptr<Session> session_;
};

}  // namespace romano::dtls
