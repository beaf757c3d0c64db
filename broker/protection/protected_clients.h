// Between the sockets and the broker core: opens what protected clients send, seals what the core
// sends them, and sees to it that nobody speaks in another's name.
//
// To the core a protected client is one behind a forwarder (MQTT-SN 1.2 section 5.5) whose wireless
// node id says who it is. So a session belongs to the key that began it and not to an address, and
// moves between brokers with its owner's name. Nothing here grows with what strangers send: all
// memory is that of the clients with keys.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "broker/core/actions.h"
#include "broker/core/limits.h"
#include "broker/core/stranger_answers.h"
#include "broker/protection/packets_heard.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"
#include "romano/protection/broker_end.h"

namespace romano::broker {

/// A client that may speak protected packets.
struct ProtectedClient {
    std::string client_id;
    protection::RobotKey key;
};

struct ProtectionCounters {
    std::uint64_t opened = 0;
    std::uint64_t sealed = 0;
    std::uint64_t foreign_client_id = 0;  // a message in another client's name
    std::uint64_t needs_protection = 0;   // a plain one in the name of a client with a key
    std::uint64_t stranger_rate = 0;      // the same, and too many at once to be answered
    std::uint64_t keyless = 0;            // not sent: the client's key was withdrawn
    std::array<std::uint64_t, protection::refusal_kinds> refused{};
};

class ProtectedClients {
public:
    /// What is known of a client's packets from before.
    using Known = std::function<std::optional<protection::Heard>(const protection::SenderId&)>;

    /// `self` and `bound` are of one record (romano/protection/reserve.h). So many times a second
    /// it is said at plain addresses that a client needs its key.
    ProtectedClients(
        const protection::SenderId& self, std::uint32_t bound,
        std::size_t stranger_answers_per_second = Limits{}.stranger_answers_per_second);
    ~ProtectedClients();

    /// These and no others. Who keeps its key is known as before.
    void set_clients(std::span<const ProtectedClient> clients, const Known& known);
    [[nodiscard]] std::size_t size() const { return by_id_.size(); }

    /// What the core is to be given, valid until the next call; empty when the datagram is dropped.
    /// A refusal that has an answer puts it into `out`.
    [[nodiscard]] Bytes admit(Instant now, const Endpoint& via, const Endpoint& from,
                              Bytes datagram, Actions& out);
    /// After each admit(): to be stored before the datagram has an effect.
    [[nodiscard]] std::optional<PacketsHeard> to_store() const;
    void on_stored();

    /// What is to be stored before seal().
    [[nodiscard]] protection::Reserve& reserve() { return reserve_; }
    /// Seals all that leaves for protected clients. What cannot be sealed has no `via` then.
    void seal(Actions& actions);

    // --- several brokers
    /// Of whom packets were taken since the last call, here or as others told.
    [[nodiscard]] std::vector<PacketsHeard> to_tell();
    /// Everything is to be told once more: there are brokers that have not heard it. Not the ends
    /// of blocks that were stored: a broker that knew better would refuse what comes before.
    void tell_all();
    void on_told(std::span<const PacketsHeard> told);

    /// Exactly, for an orderly end.
    [[nodiscard]] std::vector<PacketsHeard> heard() const;
    [[nodiscard]] ProtectionCounters counters() const;

private:
    struct Client;
    struct SenderHash {
        std::size_t operator()(const protection::SenderId& id) const;
    };

    [[nodiscard]] Bytes admit_sealed(const Endpoint& via, const Endpoint& from, Bytes datagram,
                                     Actions& out);
    [[nodiscard]] Bytes admit_plain(Instant now, const Endpoint& via, const Endpoint& from,
                                    Bytes datagram, Actions& out);
    void note(Client& client);
    void forget(Client& client);
    void count(protection::Refusal why) { ++counters_.refused[static_cast<std::size_t>(why)]; }

    protection::SenderId self_;
    protection::Reserve reserve_;
    StrangerAnswers answers_;
    std::unordered_map<std::string_view, std::unique_ptr<Client>> by_id_;  // views of their own ids
    std::unordered_map<protection::SenderId, Client*, SenderHash> by_sender_;
    std::vector<Client*> to_tell_;
    Client* to_store_ = nullptr;
    std::vector<std::uint8_t> room_;
    ProtectionCounters counters_;  // without what living ends count
};

}  // namespace romano::broker
