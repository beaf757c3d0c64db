// What stands between a client core and its socket when it speaks DTLS: handshakes when they are
// due, and messages by records. No socket.
//
// A handshake comes with the first message, after the broker has closed, and with a CONNECT: when
// the broker was heard since the handshake before, and with each second one that is not answered.
// So a broker that has lost the association is left behind as soon as the client core gives it up,
// and one that dies in the middle of a handshake soon after; one that is slow is not hurried.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/dtls/client_end.h"
#include "romano/protection/keys.h"

namespace romano::dtls {

class ClientLink {
public:
    static constexpr unsigned unanswered_connects = 2;
    static constexpr std::size_t most_waiting = 16;

    ClientLink(std::string client_id, const protection::Key& pre_shared_key, ClientEnd::Send send,
               ClientEnd::Wants wants = ClientEnd::Wants::connection_id)
        : end_(std::move(client_id), pre_shared_key, std::move(send), ClientEnd::default_suites,
               wants) {}

    /// Waits while a handshake goes on; when `most_waiting` do, the oldest is lost, and all are
    /// when a CONNECT comes: they were of a connection before.
    void send(Bytes message);
    /// The message in it, valid until the next call; empty when there is none.
    [[nodiscard]] Bytes open(Bytes datagram);
    /// As of ClientEnd.
    [[nodiscard]] std::optional<Duration> due_in() const { return end_.due_in(); }
    void on_time() { end_.on_time(); }
    /// Says goodbye to the broker.
    void close() { end_.close(); }

    [[nodiscard]] bool is_connected() const { return end_.is_connected(); }
    /// How many it has begun.
    [[nodiscard]] std::uint64_t handshakes() const { return handshakes_; }

private:
    [[nodiscard]] bool is_handshake_due(bool is_connect);

    ClientEnd end_;
    std::vector<std::vector<std::uint8_t>> waiting_;
    std::uint64_t handshakes_ = 0;
    unsigned unanswered_ = 0;  // CONNECTs since the handshake
    bool was_heard_ = false;   // since the handshake
};

}  // namespace romano::dtls
