// The protected clients of a broker with its --keys folder: who they are, and what must be stored
// so that no packet is taken twice and none is numbered twice.
//
//     clients.keys        the table: `romano keys` writes it, and a broker that runs reads it anew
//     broker.numbers      the broker's identity, place and bound of its numbers; never to be copied
//     broker.place        a place that was given and not taken yet
//     clients.heard       how far each client's packets were taken
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "broker/core/actions.h"
#include "broker/daemon/handshake_memory.h"
#include "broker/daemon/heard_file.h"
#include "broker/daemon/settings.h"
#include "broker/dtls/openssl/listener.h"
#include "broker/metrics/page.h"
#include "broker/protection/protected_clients.h"
#include "broker/rights/rights.h"
#include "romano/keys/broker_record.h"
#include "romano/keys/lock_file.h"

namespace romano::daemon {

/// Throws Refusal. Null when no folder is given.
[[nodiscard]] std::unique_ptr<class Protection> open_protection(const Settings& settings);

class Protection {
public:
    /// A table that was written since looks different.
    struct TableLook {
        std::filesystem::file_time_type changed_at;
        std::uintmax_t octets = 0;

        friend bool operator==(const TableLook&, const TableLook&) = default;
    };

    /// Throws keys::KeyError.
    Protection(std::filesystem::path folder, const broker::Limits& limits);

    /// From now on datagrams of DTLS addresses are understood. False when this broker has no place.
    [[nodiscard]] bool serve_dtls();

    /// Hands on what the core is to be given, which lives until the call returns.
    void admit(Instant now, const Endpoint& via, const Endpoint& from, Bytes datagram,
               broker::Actions& out, const dtls::Listener::Deliver& deliver);
    void seal(broker::Actions& actions);
    /// About once a second.
    void on_time(Instant now, broker::Actions& out);

    /// From time to time: the table may have changed. True when it has.
    [[nodiscard]] bool look();
    /// Of the keys in the table.
    [[nodiscard]] const std::vector<rights::KeyOwner>& owners() const { return owners_; }
    void leave();
    void add_metrics(metrics::Page& page) const;

    [[nodiscard]] broker::ProtectedClients& clients() { return clients_; }
    /// Null without serve_dtls().
    [[nodiscard]] dtls::DtlsClients* dtls_clients() { return dtls_ ? &dtls_->clients() : nullptr; }

private:
    [[nodiscard]] Bytes admit_sealed(Instant now, const Endpoint& via, const Endpoint& from,
                                     Bytes datagram, broker::Actions& out);
    [[nodiscard]] std::optional<dtls::Certificates> certificates() const;
    void read_table();
    void store_bound(std::size_t about_to_seal);
    void end_storing();
    void warn(const std::string& what);

    std::filesystem::path folder_;
    keys::LockFile lock_;
    keys::BrokerRecord record_;
    std::future<std::string> storing_;  // the record, and what went wrong: a disk takes its time
    Instant stored_again_at_ = Instant::min();
    HeardFile heard_;
    broker::ProtectedClients clients_;
    std::optional<dtls::Listener> dtls_;
    HandshakeMemory handshake_memory_;
    std::vector<broker::ProtectedClient> with_keys_;
    std::vector<rights::KeyOwner> owners_;
    TableLook read_at_;           // when the keys were read
    TableLook looked_at_;         // the last time
    std::string warned_of_;       // the last one, not to be said again
    std::uint64_t unstored_ = 0;  // datagrams that were dropped because the disk is full
};

}  // namespace romano::daemon
