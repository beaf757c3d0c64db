// A client's end of DTLS 1.2 (RFC 6347): a handshake (client_handshake.h), and then records of ours
// (record/client_records.h). No socket: datagrams in, datagrams out. A shell, for the handshake's
// timers read the real clock.
//
// It asks the broker for a Connection ID (RFC 9146) and wants none for itself. With one its address
// may change, as a NAT does it: the association goes on.
#pragma once

#include <optional>
#include <string>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/dtls/client_handshake.h"
#include "romano/dtls/record/client_records.h"
#include "romano/protection/keys.h"

namespace romano::dtls {

class ClientEnd {
public:
    using Send = ClientHandshake::Send;
    using Wants = ClientHandshake::Wants;

    /// As of ClientHandshake.
    ClientEnd(std::string identity, const protection::Key& key, Send send,
              const char* suites = default_suites, Wants wants = Wants::connection_id);

    /// A handshake, from its beginning.
    void connect();
    [[nodiscard]] bool is_connected() const { return records_.has_value(); }
    /// There was no handshake yet, it has failed, or the association has ended.
    [[nodiscard]] bool is_closed() const { return !is_connected() && !handshake_.goes_on(); }
    /// The broker knows it from any address.
    [[nodiscard]] bool may_roam() const { return is_connected() && records_->has_brokers_id(); }

    /// The first message in it, valid until the next call; empty when there is none.
    [[nodiscard]] Bytes open(Bytes datagram);
    /// False when there is no association, or the message is empty or too long.
    bool seal(Bytes message);
    /// While a handshake goes on, as of ClientHandshake.
    [[nodiscard]] std::optional<Duration> due_in() const { return handshake_.due_in(); }
    void on_time() { handshake_.on_time(); }
    /// Says goodbye.
    void close();

    static constexpr const char* default_suites = "PSK-AES128-CCM8:PSK-AES128-GCM-SHA256";

private:
    bool say(ContentType type, Bytes message);
    [[nodiscard]] Bytes take(const Record& record);

    Send send_;
    ClientHandshake handshake_;
    std::optional<ClientRecords> records_;  // while it is connected
};

}  // namespace romano::dtls
