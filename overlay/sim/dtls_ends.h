// Both ends of DTLS in a simulated world: a robot's, and the shipped DtlsClients of a broker,
// behind handshakes of one round trip (dtls_records.h). Some robots have a Connection ID (RFC
// 9146), others are known by their addresses.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "broker/core/actions.h"
#include "broker/dtls/dtls_clients.h"
#include "broker/protection/protected_clients.h"
#include "overlay/sim/dtls_records.h"
#include "romano/base/bytes.h"
#include "romano/base/random.h"
#include "romano/dtls/record/client_records.h"
#include "romano/protection/reserve.h"

namespace romano::sim {

class DtlsRobotEnd {
public:
    using Put = std::function<void(Bytes datagram)>;

    DtlsRobotEnd(std::string robot, bool wants_id, DtlsRecords& world, std::uint64_t seed);

    /// Waits while a handshake goes on; with each the question is repeated. A new one is due as it
    /// is for a ClientLink (romano/dtls/client_link.h).
    void send(Bytes message, const Put& put);
    /// The message in it, which lives until the next call; empty when there is none.
    [[nodiscard]] Bytes open(Bytes datagram, const Put& put);
    /// It has another broker address, and makes another handshake there if it must.
    void on_other_broker();
    [[nodiscard]] bool has_id() const { return wants_id_; }

private:
    void ask(const Put& put);
    void seal(Bytes message, const Put& put);
    void on_answer(Bytes answer, const Put& put);
    [[nodiscard]] bool is_handshake_due(Bytes message);

    std::string robot_;
    bool wants_id_;
    DtlsRecords& world_;
    Random random_;
    std::optional<std::uint64_t> question_;  // while a handshake goes on
    std::optional<dtls::ClientRecords> records_;
    dtls::AssociationId id_{};  // of the association whose records these are
    bool was_heard_ = false;
    unsigned unanswered_ = 0;
    std::vector<std::vector<std::uint8_t>> waiting_;
};

class DtlsBrokerEnd {
public:
    using Deliver = std::function<void(const dtls::Message& message)>;

    /// `life`: this broker in this life. `place` is its own in the fleet.
    DtlsBrokerEnd(std::string life, std::uint32_t place, std::uint32_t bound, DtlsRecords& world,
                  std::span<const broker::ProtectedClient> clients, std::uint64_t seed);

    void take(const dtls::Path& path, Bytes datagram, broker::Actions& out, const Deliver& deliver);
    void seal(broker::Actions& actions);
    [[nodiscard]] dtls::DtlsClients& clients() { return clients_; }
    [[nodiscard]] protection::Reserve& reserve() { return reserve_; }

private:
    void on_question(const dtls::Path& path, Bytes body, broker::Actions& out);

    std::string life_;
    std::uint32_t place_;
    DtlsRecords& world_;
    Random random_;
    protection::Reserve reserve_;
    dtls::DtlsClients clients_;
};

}  // namespace romano::sim
