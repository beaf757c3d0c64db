// Clients of DTLS in front of a broker without sockets.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "romano/dtls/client_end.h"
#include "romano/mqttsn/decode.h"
#include "tests/broker/dtls/broker_with_dtls.h"
#include "tests/romano/dtls/openssl_ends.h"

namespace romano::dtls::broker_with_dtls {

/// A client's end, and the datagrams between it and a broker.
template <typename End>
struct ClientWith {
    /// `more` for the end.
    explicit ClientWith(std::string identity, const protection::RobotKey& key, auto... more)
        : end(
              std::move(identity), protection::pre_shared_key(key),
              [this](Bytes datagram) { outbox.emplace_back(datagram.begin(), datagram.end()); },
              more...) {}

    /// Until nobody has anything to say.
    void exchange(Broker& broker) {
        while (!outbox.empty()) {
            const auto sent = std::exchange(outbox, {});
            for (const Octets& datagram : sent) {
                last_sent = datagram;
                for (const Sent& answer : broker.take(from, datagram)) hear(answer.octets);
            }
        }
    }
    void hear(const Octets& datagram) {
        last_heard = datagram;
        const Bytes message = end.open(datagram);
        if (!message.empty()) received.emplace_back(message.begin(), message.end());
    }
    bool connect(Broker& broker) {
        end.connect();
        exchange(broker);
        return end.is_connected();
    }
    /// What is answered to a message; none when nothing is.
    std::optional<mqttsn::MsgType> ask(Broker& broker, const Octets& message) {
        received.clear();
        if (!end.seal(message)) return std::nullopt;
        exchange(broker);
        if (received.size() != 1) return std::nullopt;
        const auto frame = mqttsn::decode_frame(received[0]);
        return frame ? std::optional{frame->type} : std::nullopt;
    }

    std::vector<Octets> outbox;
    End end;
    Endpoint from = place;
    Octets last_sent;
    Octets last_heard;
    std::vector<Octets> received;
};

/// OpenSSL's, with its record layer; and ours.
using Client = ClientWith<openssl_ends::Client>;
using OwnClient = ClientWith<ClientEnd>;

}  // namespace romano::dtls::broker_with_dtls
