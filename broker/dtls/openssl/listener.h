// A broker's DTLS addresses: between the sockets and the core, handshakes and what they lead to.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "broker/core/actions.h"
#include "broker/dtls/dtls_clients.h"
#include "broker/dtls/openssl/handshakes.h"
#include "broker/protection/protected_clients.h"
#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/protection/keys.h"

namespace romano::dtls {

class Listener {
public:
    /// What the core is to be given, valid until the call returns.
    using Deliver = std::function<void(const Message& message)>;

    /// As of Handshakes.
    Listener(const Speaker& self, const protection::Key& secret,
             const std::optional<Certificates>& certificates = std::nullopt);

    void set_clients(std::span<const broker::ProtectedClient> clients) {
        clients_.set_clients(clients);
    }
    void take(Instant now, const Path& path, Bytes datagram, broker::Actions& out,
              const Deliver& deliver);
    void seal(broker::Actions& actions) { clients_.seal(actions); }
    /// About once a second.
    void on_time(Instant now, broker::Actions& out) { handshakes_.on_time(now, out); }

    [[nodiscard]] DtlsClients& clients() { return clients_; }
    [[nodiscard]] const DtlsClients& clients() const { return clients_; }
    [[nodiscard]] const Handshakes& handshakes() const { return handshakes_; }

private:
    void take_record(Instant now, const Path& path, const Record& record, broker::Actions& out,
                     const Deliver& deliver);
    void take_protected(const Path& path, const Record& record, broker::Actions& out,
                        const Deliver& deliver);
    void take_of_handshake(Instant now, const Path& path, const Record& record,
                           broker::Actions& out);

    DtlsClients clients_;
    Handshakes handshakes_;
};

}  // namespace romano::dtls
