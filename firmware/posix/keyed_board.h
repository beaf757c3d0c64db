// A board whose robot has a key: what it sends goes by protected packets or by DTLS, and so does
// what it is sent. Discovery stays as it is: what the robot hears there is a hint and no more.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "firmware/robot/board.h"
#include "romano/base/bytes.h"
#include "romano/base/endpoint.h"
#include "romano/base/time.h"
#include "romano/keys/client_packets.h"
#include "romano/keys/client_speech.h"

namespace romano::firmware {

/// In front of another board, which stays where it is, as this does. It speaks to one broker
/// address at a time, the one that it sent to last.
class KeyedBoard {
public:
    KeyedBoard(const romano_board& behind, std::shared_ptr<keys::ClientPackets> key);
    KeyedBoard(const KeyedBoard&) = delete;
    KeyedBoard& operator=(const KeyedBoard&) = delete;

    [[nodiscard]] const romano_board& board() const { return own_; }
    /// When the robot is to look for datagrams at the latest, though none come; empty: whenever.
    [[nodiscard]] std::optional<Duration> due_in() const {
        return speech_ ? speech_->due_in() : std::nullopt;
    }

private:
    void put(const romano_address& to, Bytes datagram) const;
    void send(const romano_address& to, Bytes message);
    const std::uint8_t* receive(romano_address* from, std::uint32_t* size);

    const romano_board& behind_;
    std::shared_ptr<keys::ClientPackets> key_;
    romano_board own_;
    Endpoint broker_;
    std::unique_ptr<keys::ClientSpeech> speech_;  // to the broker; null: to none yet
};

}  // namespace romano::firmware
