// How a client with a key speaks to one broker address, by protected packets or by DTLS: messages
// on the client's side, datagrams on the broker's. No socket.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/keys/client_packets.h"

namespace romano::keys {

class ClientSpeech {
public:
    using Put = std::function<void(Bytes datagram)>;

    ClientSpeech() = default;
    /// A client of DTLS says goodbye.
    virtual ~ClientSpeech() = default;
    ClientSpeech(const ClientSpeech&) = delete;
    ClientSpeech& operator=(const ClientSpeech&) = delete;

    /// Leaves at once, or when a handshake is done. Nothing leaves when the key has no number left.
    virtual void send(Bytes message) = 0;
    /// The message in it, valid until the next call; empty when there is none for this client.
    [[nodiscard]] virtual Bytes open(Bytes datagram) = 0;

    /// When on_time() is to be called; empty: not at all. Earlier calls are harmless.
    [[nodiscard]] virtual std::optional<Duration> due_in() const { return std::nullopt; }
    virtual void on_time() {}

    /// Handshakes that it has begun: none with protected packets.
    [[nodiscard]] virtual std::uint64_t handshakes() const { return 0; }
};

/// What the key is used for decides. `put` sends a datagram to the broker, and outlives this.
[[nodiscard]] std::unique_ptr<ClientSpeech> speak(std::shared_ptr<ClientPackets> key,
                                                  ClientSpeech::Put put);

}  // namespace romano::keys
